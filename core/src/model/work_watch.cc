#include "genphys/work_watch.h"

#include "model/cat.h"

namespace genphys {

WorkWatch::WorkWatch(Check check, int64_t spell)
    : check_(std::move(check)), spell_(spell), outer_(thread_.watch), left_before_(thread_.left) {
  thread_.watch = this;
  thread_.left = spell_;
}

WorkWatch::~WorkWatch() {
  thread_.watch = outer_;
  thread_.left = left_before_;
}

Status WorkWatch::Ask() {
  const WorkWatch* const watch = thread_.watch;
  return watch == nullptr || !watch->check_ ? absl::OkStatus() : watch->check_();
}

Status WorkWatch::Spent(int64_t work) {
  thread_.left -= work;
  if (thread_.left >= 0) return absl::OkStatus();
  thread_.left = Spell();
  return Ask();
}

void WorkWatch::EndSpell() {
  thread_.left = Spell();
  if (thread_.looks > thread_.looks_max) {
    throw TooMuchWork(
        Cat("shapes near each other take more than ", thread_.looks_max, " looks at their corners and triangles"));
  }
  Status status = Ask();
  if (!status.ok()) throw CutShort(std::move(status));
}

WorkBudget::WorkBudget(int64_t looks_max)
    : looks_before_(std::exchange(WorkWatch::thread_.looks, 0)),
      looks_max_before_(std::exchange(WorkWatch::thread_.looks_max, looks_max)) {
  WorkWatch::thread_.left = WorkWatch::Spell();
}

WorkBudget::~WorkBudget() {
  WorkWatch::thread_.looks = looks_before_;
  WorkWatch::thread_.looks_max = looks_max_before_;
}

}  // namespace genphys
