#pragma once
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

#include "genphys/status.h"

namespace genphys {

/// Thrown out of work with which nobody is to go on.
class CutShort : public std::exception {
 public:
  explicit CutShort(Status why) : why_(std::move(why)) {}
  const Status& why() const { return why_; }
  const char* what() const noexcept override { return "cut short"; }

 private:
  Status why_;
};

/// Thrown out of work on shapes beyond a WorkBudget.
class TooMuchWork : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// While one lives, the thread that made it asks `check` now and then as it works, and what works throws CutShort with
/// the answer unless that is OK. Of two the newer one is asked. What takes long tells by Spend() what it does, in
/// pieces: that is deep below calls of engines, which have nothing to hand such a thing down by, and so it belongs to
/// the thread.
class WorkWatch {
 public:
  using Check = std::function<Status()>;
  /// Units of work between two questions, each of which is a few nanoseconds: to ask costs a thousandth of that.
  static constexpr int64_t kUsualSpell = 1 << 16;

  /// Only tests have a reason to ask more often. No `check`: nothing is cut short while it lives.
  explicit WorkWatch(Check check, int64_t spell = kUsualSpell);
  ~WorkWatch();
  WorkWatch(const WorkWatch&) = delete;
  WorkWatch& operator=(const WorkWatch&) = delete;

  /// So much was done, or is about to be. Throws CutShort or TooMuchWork.
  static void Spend(int64_t work) {
    if ((thread_.left -= work) < 0) [[unlikely]]
      EndSpell();
  }
  /// The same of looking at shapes: corners, triangles and the like, for which a WorkBudget has a bound.
  static void Look(int64_t work) {
    thread_.looks += work;
    Spend(work);
  }
  /// What Spend() would throw, for work that has to come to a good end first.
  static Status Spent(int64_t work);
  /// The answer as it would be now.
  static Status Ask();

 private:
  friend class WorkBudget;

  struct Thread {
    int64_t left;  // of this spell
    int64_t looks;
    int64_t looks_max;
    const WorkWatch* watch;
  };

  static void EndSpell();
  static int64_t Spell() { return thread_.watch == nullptr ? kUsualSpell : thread_.watch->spell_; }

  static inline constinit thread_local Thread thread_{kUsualSpell, 0, std::numeric_limits<int64_t>::max(), nullptr};

  const Check check_;
  const int64_t spell_;
  const WorkWatch* const outer_;
  const int64_t left_before_;
};

/// While it lives, TooMuchWork is thrown where looking at shapes on this thread comes to much more than `looks_max` in
/// all: always at the same place of the same work, however long that takes.
class WorkBudget {
 public:
  explicit WorkBudget(int64_t looks_max);
  ~WorkBudget();
  WorkBudget(const WorkBudget&) = delete;
  WorkBudget& operator=(const WorkBudget&) = delete;

 private:
  const int64_t looks_before_;
  const int64_t looks_max_before_;
};

}  // namespace genphys
