#pragma once
#include <map>
#include <string>
#include <vector>

#include "contact_solver.h"
#include "genphys/backend.h"

namespace genphys::spheres_backend {

/// Spheres and planes, each tested against each: what matters here is to be right and short.
class World final : public BackendWorld {
 public:
  explicit World(const StepperSettings& settings) : settings_(settings) {}

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override { bodies_.erase(row); }
  void SetActive(std::span<const EntityRow> rows, bool active) override;
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override { settings_ = settings; }
  void Collide(const PairRule& rule, ContactBuffer& contacts) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;
  void CastRays(const PairRule& rule, std::span<const Ray> rays, uint64_t collides_with_bits,
                std::span<RayHit> hits) override;
  void FindOnSegment(const Ray& segment, std::vector<GeometryRow>& found) override;
  void FindInBounds(const Bounds& bounds, std::vector<GeometryRow>& found) override;
  // Every solve starts from nothing but its arguments.
  void SaveState(std::string&) const override {}

 private:
  struct Part {
    GeometryRow row{};
    Shape shape;
    Pose pose_in_entity;
  };
  struct Body {
    MassProperties mass;  // of a dynamic body
    bool is_static = false;
    bool is_active = true;
    Pose pose;
    std::vector<Part> parts;
  };

  void CollideBodies(const PairRule& rule, EntityRow row_a, EntityRow row_b, ContactBuffer& contacts) const;
  std::vector<GeometryRow> AllRows() const;

  StepperSettings settings_;
  std::map<EntityRow, Body> bodies_;
};

}  // namespace genphys::spheres_backend
