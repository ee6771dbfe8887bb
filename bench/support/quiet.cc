#include "quiet.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace genphys::bench {
namespace {

// Of all processors together, in seconds since the machine started.
double IdleTime() {
  std::ifstream file("/proc/stat");
  std::string name;
  double user = 0, nice = 0, system = 0, idle = 0, io_wait = 0;
  if (!(file >> name >> user >> nice >> system >> idle >> io_wait)) throw std::runtime_error("/proc/stat is no help");
  return (idle + io_wait) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

OthersWatch::OthersWatch(std::vector<const ChildProcess*> ours) : ours_(std::move(ours)) {}

OthersWatch::Reading OthersWatch::Read() const {
  Reading reading;
  reading.time = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  reading.idle = IdleTime();
  rusage self{};
  getrusage(RUSAGE_SELF, &self);
  reading.ours = Seconds(self.ru_utime) + Seconds(self.ru_stime);
  for (const ChildProcess* child : ours_) reading.ours += child->cpu_time();
  return reading;
}

void OthersWatch::Begin() { begin_ = Read(); }

double OthersWatch::End() const {
  const Reading end = Read();
  const double elapsed = end.time - begin_.time;
  const double busy = elapsed * std::thread::hardware_concurrency() - (end.idle - begin_.idle);
  // Idle time is told in ticks, so that it may be a little off.
  return std::max(0.0, (busy - (end.ours - begin_.ours)) / elapsed);
}

double LoadAverage() {
  double load = 0;
  if (!(std::ifstream("/proc/loadavg") >> load)) throw std::runtime_error("/proc/loadavg is no help");
  return load;
}

}  // namespace genphys::bench
