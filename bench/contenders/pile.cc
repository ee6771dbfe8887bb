#include "pile.h"

#include "dice.h"

namespace genphys::bench {

Scene PileOf(const PileOptions& options) {
  constexpr double kSpacing = 1.3;
  constexpr double kAside = 0.3;
  constexpr double kTurn = 0.3;
  Scene scene{.has_ground = true, .friction = 0.5, .restitution = options.restitution};
  Dice dice(options.seed);
  for (int layer = 0; layer < options.layers; ++layer) {
    const double aside = layer % 2 == 0 ? -kAside : kAside;
    for (int i = 0; i < options.row * options.row; ++i) {
      Pose pose =
          At(kSpacing * (i % options.row) + aside, kSpacing * (i / options.row) + aside, 0.6 + options.rise * layer);
      pose.orientation = Turn(kTurn * dice.Next(), Vector3::UnitZ());
      scene.Add(Box{{0.5, 0.5, 0.5}}, 1, pose);
    }
  }
  return scene;
}

}  // namespace genphys::bench
