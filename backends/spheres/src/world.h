#pragma once
#include <map>
#include <string>
#include <vector>

#include "contact_solver.h"
#include "genphys/backend.h"

namespace genphys::spheres_backend {

/// Spheres and planes: what matters here is to be right and short.
class World final : public BackendWorld {
 public:
  explicit World(const StepperSettings& settings) : settings_(settings) {}

  void AddBody(const BodyDesc& desc, const StateArrays& state) override;
  void RemoveBody(EntityRow row) override {
    bodies_.erase(row);
    std::erase_if(parts_, [&](const auto& part) { return part.second.entity == row; });
  }
  // Whoever is not among the rows of a solve is immovable in it.
  void SetActive(std::span<const EntityRow>, bool) override {}
  void WriteState(std::span<const EntityRow> rows, const StateArrays& state) override;
  void SetStepper(const StepperSettings& settings) override { settings_ = settings; }
  void FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) override;
  void Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
             std::span<JointRow> joint_rows) override;
  // Every solve starts from nothing but its arguments.
  void SaveState(std::string&) const override {}

 private:
  struct Part {
    EntityRow entity{};
    Shape shape;
    Pose pose_in_entity;
  };
  struct Body {
    MassProperties mass;  // of a dynamic body
    Pose pose;
  };

  StepperSettings settings_;
  std::map<EntityRow, Body> bodies_;
  std::map<GeometryRow, Part> parts_;
};

}  // namespace genphys::spheres_backend
