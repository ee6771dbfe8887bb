#include "step/slide.h"

#include <algorithm>

namespace genphys {
namespace {

// Of the time in which its speed might come to nothing: so far goes a step of the integration.
constexpr double kStride = 0.2;
// Of the speed that it might lose in all: what is slower has stopped.
constexpr double kStopped = 1e-6;

}  // namespace

// Runge-Kutta, of fourth order, in steps that become as short as its direction turns fast.
void Slide::GoOn(double time) {
  whole_ += time;
  const double fastest = drive_.norm() + brake_, stopped = kStopped * fastest * time;
  while (time > 0 && !has_stopped_) {
    const double speed = slip_.norm();
    if (speed <= stopped) {
      has_stopped_ = true;
      slip_.setZero();
      break;
    }
    const double step = std::min(time, kStride * speed / fastest);
    const auto change = [&](const Vector3& slip) -> Vector3 { return drive_ - brake_ * slip.stableNormalized(); };
    const Vector3 a = change(slip_), b = change(slip_ + step / 2 * a), c = change(slip_ + step / 2 * b),
                  d = change(slip_ + step * c);
    const Vector3 mean = (a + 2 * b + 2 * c + d) / 6;
    way_ += step * (slip_ + step / 6 * (a + b + c));
    slip_ += step * mean;
    led_ += step / brake_ * (drive_ - mean);
    time_ += step;
    time -= step;
  }
  if (time <= 0 || !is_driven()) return;
  // It sets off the way it is driven.
  const Vector3 gain = drive_ - brake_ * drive_.normalized();
  way_ += time * slip_ + time * time / 2 * gain;
  slip_ += time * gain;
}

}  // namespace genphys
