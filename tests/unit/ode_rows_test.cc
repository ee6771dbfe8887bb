// Each row that ODE is given is composed of joints of its own: what comes out is what the row says.
#include <gtest/gtest.h>

#include <random>

#include "genphys/backends/ode.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

// A ball joint corrects by a thousandth more of an arm than the point has; all else is rounding.
constexpr double kComposed = 1e-4;

class Two {
 public:
  explicit Two(uint32_t seed, bool direct, bool second_moves) : random_(seed) {
    const auto backend = MakeOdeBackend();
    world_ = backend->CreateWorld(
        {.solver = direct ? Solver::kDirect : Solver::kIterative, .substeps = 1, .iterations = 1000});
    state_.Resize(2);
    for (uint32_t i = 0; i < 2; ++i) {
      RigidBody body;
      body.motion_type = i == 1 && !second_moves ? MotionType::kKinematic : MotionType::kDynamic;
      mass_[i].mass = 1.2 + Number();
      mass_[i].tensor = Vector3(2 + Number(), 2 + Number(), 2 + Number()).asDiagonal();
      mass_[i].inverse_tensor = mass_[i].tensor.inverse();
      const EntityRow row{i};
      state_.ids[i] = EntityId(i, 1);
      state_.set_pose(row, {Vector(), Quaternion(1.1, Number(), Number(), Number()).normalized()});
      state_.linear_velocities.col(i) = Vector();
      state_.angular_velocities.col(i) = Vector();
      world_->AddBody({row, EntityId(i, 1), body, mass_[i], {}}, state_);
      if (body.motion_type == MotionType::kDynamic) rows_.push_back(row);
      inverse_mass_[i] = body.motion_type == MotionType::kDynamic ? 1 / mass_[i].mass : 0;
      const Matrix3 turn = state_.pose(row).orientation.toRotationMatrix();
      inverse_tensor_[i] = turn * mass_[i].inverse_tensor * turn.transpose() * (inverse_mass_[i] > 0 ? 1 : 0);
    }
  }

  double Number() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  Vector3 Vector() { return {Number(), Number(), Number()}; }

  Eigen::Matrix<double, 12, 1> Jacobian(const JointRow& row) const {
    Eigen::Matrix<double, 12, 1> jacobian = Eigen::Matrix<double, 12, 1>::Zero();
    for (uint32_t i = 0; i < 2; ++i) {
      const double sign = i == 0 ? -1 : 1;
      auto linear = jacobian.segment<3>(6 * i);
      auto angular = jacobian.segment<3>(6 * i + 3);
      if (row.kind == JointRow::Kind::kLinear) {
        linear = sign * row.axis;
        angular = sign * (row.point - state_.positions.col(i)).cross(row.axis);
      } else {
        angular = row.kind == JointRow::Kind::kAngular ? Vector3(sign * row.axis) : i == 0 ? row.axis : row.axis_b;
      }
    }
    return jacobian;
  }

  /// The dense solution beside ODE's, of rows that are all unbounded or one.
  void ExpectSolved(std::vector<JointRow> rows) {
    const auto count = static_cast<Eigen::Index>(rows.size());
    Eigen::Matrix<double, 12, 1> before;
    Eigen::Matrix<double, 12, 12> mobility = Eigen::Matrix<double, 12, 12>::Zero();
    for (uint32_t i = 0; i < 2; ++i) {
      before.segment<3>(6 * i) = state_.linear_velocities.col(i);
      before.segment<3>(6 * i + 3) = state_.angular_velocities.col(i);
      mobility.block<3, 3>(6 * i, 6 * i) = inverse_mass_[i] * Matrix3::Identity();
      mobility.block<3, 3>(6 * i + 3, 6 * i + 3) = inverse_tensor_[i];
    }
    Eigen::MatrixXd jacobian(count, 12);
    Eigen::VectorXd wanted(count), softness(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      JointRow& row = rows[static_cast<size_t>(i)];
      row.a = EntityRow{0};
      row.b = EntityRow{1};
      jacobian.row(i) = Jacobian(row).transpose();
      wanted[i] = row.target;
      softness[i] = row.softness;
    }
    Eigen::MatrixXd matrix = jacobian * mobility * jacobian.transpose();
    matrix.diagonal() += softness;
    Eigen::VectorXd impulses = matrix.fullPivLu().solve(wanted - jacobian * before);
    if (count == 1) impulses[0] = std::clamp(impulses[0], rows[0].lower, rows[0].upper);
    const Eigen::Matrix<double, 12, 1> after = before + mobility * jacobian.transpose() * impulses;

    ContactBuffer none;
    world_->Solve(1.0 / 120, rows_, state_, none, rows);

    for (uint32_t i = 0; i < 2; ++i) {
      EXPECT_LE((state_.linear_velocities.col(i) - after.segment<3>(6 * i)).norm(), kComposed);
      EXPECT_LE((state_.angular_velocities.col(i) - after.segment<3>(6 * i + 3)).norm(), kComposed);
    }
    for (Eigen::Index i = 0; i < count; ++i) {
      EXPECT_NEAR(rows[static_cast<size_t>(i)].impulse, impulses[i], kComposed) << "row " << i;
    }
  }

  JointRow Row(JointRow::Kind kind) {
    return {.kind = kind,
            .axis = Vector().normalized(),
            .point = point_,
            .axis_b = Vector(),
            .target = Number(),
            .softness = 0.1};
  }

  /// Perpendicular rows at one point.
  std::vector<JointRow> Block(uint8_t count) {
    const Matrix3 axes = Quaternion(1.1, Number(), Number(), Number()).normalized().toRotationMatrix();
    std::vector<JointRow> rows;
    for (uint8_t i = 0; i < count; ++i) {
      rows.push_back(Row(JointRow::Kind::kLinear));
      rows.back().axis = axes.col(i);
    }
    rows.front().block = count;
    return rows;
  }

 private:
  std::mt19937 random_;
  std::unique_ptr<BackendWorld> world_;
  StateArrays state_;
  MassProperties mass_[2];
  double inverse_mass_[2] = {};
  Matrix3 inverse_tensor_[2];
  std::vector<EntityRow> rows_;
  Vector3 point_ = Vector3(0.3, -0.2, 0.7);
};

class OdeRows : public ::testing::TestWithParam<std::tuple<bool, bool>> {
 protected:
  static constexpr uint32_t kTrials = 20;
  template <typename Test>
  void Try(Test&& test) {
    for (uint32_t seed = 0; seed < kTrials; ++seed) {
      Two two(seed, std::get<0>(GetParam()), std::get<1>(GetParam()));
      test(two, seed);
    }
  }
};

TEST_P(OdeRows, HoldAPoint) {
  Try([](Two& two, uint32_t) { two.ExpectSolved(two.Block(3)); });
}

TEST_P(OdeRows, HoldALine) {
  Try([](Two& two, uint32_t) { two.ExpectSolved(two.Block(2)); });
}

TEST_P(OdeRows, ActAlongALine) {
  Try([](Two& two, uint32_t) { two.ExpectSolved({two.Row(JointRow::Kind::kLinear)}); });
}

TEST_P(OdeRows, ActAboutALine) {
  Try([](Two& two, uint32_t) { two.ExpectSolved({two.Row(JointRow::Kind::kAngular)}); });
}

TEST_P(OdeRows, TieTwoSpins) {
  Try([](Two& two, uint32_t) { two.ExpectSolved({two.Row(JointRow::Kind::kGeared)}); });
}

TEST_P(OdeRows, DoNoMoreThanTheyMay) {
  for (const auto kind : {JointRow::Kind::kLinear, JointRow::Kind::kAngular}) {
    Try([kind](Two& two, uint32_t) {
      JointRow row = two.Row(kind);
      row.lower = -(row.upper = 0.1);
      two.ExpectSolved({row});
    });
  }
}

TEST_P(OdeRows, ActOneWayOnly) {
  for (const auto kind : {JointRow::Kind::kLinear, JointRow::Kind::kAngular}) {
    Try([kind](Two& two, uint32_t seed) {
      JointRow row = two.Row(kind);
      (seed % 2 == 0 ? row.lower : row.upper) = 0;
      two.ExpectSolved({row});
    });
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, OdeRows, ::testing::Combine(::testing::Bool(), ::testing::Bool()));

}  // namespace
}  // namespace genphys::testing
