#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "genphys/contact.h"

namespace genphys::ode_backend {

/// The impulses that held contacts at the last solve. ODE itself starts each solve from nothing and comes nearer by
/// sweeps, of which a tower needs as many as the square of its height. What held something that rests is therefore
/// given to its bodies before a solve, which then only has to find how it differs from that.
class WarmStart {
 public:
  /// A pair of geometries of two bodies, as they were added.
  struct Key {
    GeometryRow a{};
    GeometryRow b{};
    uint64_t serial_a = 0;
    uint64_t serial_b = 0;
    auto operator<=>(const Key&) const = default;
  };

  /// What the last solve says of a point.
  struct Recalled {
    Vector3 given = Vector3::Zero();   // N*s, what to give to b: nothing where something slipped
    Vector3 braked = Vector3::Zero();  // N*s, of friction, on b, in the mean of the points of its bodies; or nothing
    double grip = 0;                   // N*s, the most that it could have been
    // Along which of two axes it can hold for others of its pair, too, which hold along the other for it.
    std::optional<uint32_t> shared_axis;
  };

  /// Begins a solve with nothing to remember yet; what the last one left can be recognised.
  void Begin();

  /// What the last solve left of a pair.
  struct Kept;

  /// Calls visit(key, keep) with each pair of the last solve, and what to call for what it left of that.
  template <typename Visit>
  void VisitPairs(Visit visit) const {
    for (const Pair& pair : now_.pairs) visit(pair.key, [&] { return Keep(pair); });
  }
  /// Between two solves: as if the last one had left this, too.
  void Return(const Kept& kept);

  /// Forgets what was solved since Begin(), as for the same solve once more.
  void TakeBack() { std::swap(now_, before_); }

  /// Adds a `pair` of the contact buffer with its `points` and recalls each. False if the pair was not there before.
  /// `frame` is the pose of the side in which its points stand still.
  bool Add(const Key& key, const Pose& frame, const ContactPair& pair, std::span<const ContactPoint> points,
           std::span<Recalled> recalled);

  /// Remembers what the solve found, of all `points` of the contact buffer.
  void End(std::span<const ContactPoint> points);

  /// Appends all that the next solve depends on.
  void Save(std::string& bytes) const;
  /// Appends what was kept of a pair.
  static void Save(const Kept& kept, std::string& bytes);

 private:
  struct Pair {
    Key key;
    uint32_t first = 0;  // in places and impulses
    uint32_t count = 0;
    uint32_t first_point = 0;          // in the contact buffer
    double interval = 0;               // s, for which the impulses acted
    Vector3 braked = Vector3::Zero();  // N*s, of friction on b, in the mean of points: see ShareBraked()
    double grip = 0;                   // N*s, the most that it could have been, in the same mean
    double strain = 1;                 // the part that it took of what friction may hold
    double load = 0;                   // N*s, of friction in all
    double friction = 0;               // the most that its points can hold, as a part of what presses them
  };
  struct Memory {
    std::vector<Pair> pairs;
    std::vector<Vector3> places;    // in the frame
    std::vector<Vector3> impulses;  // on b, across the normal, N*s
    std::vector<double> pressures;  // on b, along it, N*s
    void Clear();
  };

  Kept Keep(const Pair& pair) const;
  static void Save(const Pair& pair, std::span<const Vector3> places, std::span<const Vector3> impulses,
                   std::span<const double> pressures, std::string& bytes);
  const Pair* Find(const Key& key);
  double Bore(uint32_t point) const { return found_[point] ? before_.pressures[*found_[point]] : 0; }
  std::optional<uint32_t> FindPoint(const Pair& old, const Vector3& place) const;
  Recalled RecallAt(const Pair& old, double scale, uint32_t point, const Vector3& normal) const;
  void ShareBraked(std::span<const ContactPoint> points);
  void ShareOut(const Pair& old, std::span<Recalled> recalled);
  bool ShareOut(const Pair& old, std::span<const uint32_t> order, bool is_first_alone, std::span<Recalled> recalled);

  Memory now_;
  Memory before_;
  std::vector<std::pair<Key, uint32_t>> index_;  // of before_, ascending
  size_t next_ = 0;                              // in the index, after who was found last: most are found in its order
  // Kept between calls for their memory only.
  std::vector<std::optional<uint32_t>> found_;  // which of before_ the points of a pair were
  std::vector<uint32_t> order_;
};

struct WarmStart::Kept {
  Pair pair;
  std::vector<Vector3> places;
  std::vector<Vector3> impulses;
  std::vector<double> pressures;
};

}  // namespace genphys::ode_backend
