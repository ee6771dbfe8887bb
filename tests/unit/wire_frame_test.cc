#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <vector>

#include "genphys/wire/decode.h"
#include "genphys/wire/encode_frame.h"
#include "wire_round_trip.h"

namespace genphys {
namespace {

template <typename Scalar>
std::vector<Scalar> Scalars(const std::string& bytes) {
  std::vector<Scalar> scalars(bytes.size() / sizeof(Scalar));
  if (!scalars.empty()) std::memcpy(scalars.data(), bytes.data(), scalars.size() * sizeof(Scalar));
  return scalars;
}

/// Row r has the id (r, generation), and its k-th column begins with 1000 * r + 100 * k. Generation 0 is a hole.
StateArrays State(const std::vector<uint32_t>& generations) {
  StateArrays state;
  state.Resize(static_cast<uint32_t>(generations.size()));
  for (uint32_t row = 0; row < state.rows(); ++row) {
    if (generations[row] != 0) state.ids[row] = EntityId(row, generations[row]);
    const double base = 1000.0 * row;
    state.positions.col(row) = Vector3(base, base + 1, base + 2);
    state.orientations.col(row) = Column4(base + 100, base + 101, base + 102, base + 103);
    state.linear_velocities.col(row) = Vector3(base + 200, base + 201, base + 202);
    state.angular_velocities.col(row) = Vector3(base + 300, base + 301, base + 302);
    state.net_forces.col(row) = Vector3(base + 400, base + 401, base + 402);
    state.net_torques.col(row) = Vector3(base + 403, base + 404, base + 405);
  }
  return state;
}

/// What a frame of these rows has in a column that begins with `first` and is `width` wide.
template <typename Scalar>
std::vector<Scalar> Expected(const std::vector<uint32_t>& rows, double first, int width) {
  std::vector<Scalar> scalars;
  for (const uint32_t row : rows) {
    for (int i = 0; i < width; ++i) scalars.push_back(static_cast<Scalar>(1000.0 * row + first + i));
  }
  return scalars;
}

v1::FrameRequest Everything() {
  v1::FrameRequest request;
  request.set_poses(true);
  request.set_velocities(true);
  request.set_net_forces(true);
  return request;
}

v1::Frame Encoded(const StateArrays& state, const v1::FrameRequest& request) {
  v1::WorldStamp stamp;
  stamp.set_step(42);
  std::string bytes;
  AppendStamp(stamp, bytes);
  const size_t stamp_size = bytes.size();
  const FrameEncoder encoder(state, request);
  bytes.resize(stamp_size + encoder.size());
  EXPECT_EQ(encoder.Write(bytes.data() + stamp_size), bytes.data() + bytes.size());
  v1::Frame frame;
  EXPECT_TRUE(frame.ParseFromString(bytes));
  return frame;
}

template <typename Scalar>
void ExpectColumns(const v1::Frame& frame, const std::vector<uint32_t>& rows) {
  EXPECT_EQ(Scalars<Scalar>(frame.positions()), Expected<Scalar>(rows, 0, 3));
  EXPECT_EQ(Scalars<Scalar>(frame.orientations()), Expected<Scalar>(rows, 100, 4));
  EXPECT_EQ(Scalars<Scalar>(frame.linear_velocities()), Expected<Scalar>(rows, 200, 3));
  EXPECT_EQ(Scalars<Scalar>(frame.angular_velocities()), Expected<Scalar>(rows, 300, 3));
  EXPECT_EQ(Scalars<Scalar>(frame.net_forces()), Expected<Scalar>(rows, 400, 6));
}

TEST(WireFrame, HasARowForEachLivingEntity) {
  const StateArrays state = State({1, 1, 1, 0, 0});

  const v1::Frame frame = Encoded(state, Everything());

  EXPECT_EQ(frame.stamp().step(), 42u);
  EXPECT_EQ(frame.scalar(), v1::SCALAR_FLOAT64);
  EXPECT_EQ(DecodeIds(frame.entity_ids()), (std::vector<EntityId>{{0, 1}, {1, 1}, {2, 1}}));
  ExpectColumns<double>(frame, {0, 1, 2});
}

TEST(WireFrame, LeavesHolesOut) {
  const v1::Frame frame = Encoded(State({0, 1, 0, 1, 0}), Everything());

  EXPECT_EQ(DecodeIds(frame.entity_ids()), (std::vector<EntityId>{{1, 1}, {3, 1}}));
  ExpectColumns<double>(frame, {1, 3});
}

TEST(WireFrame, IsInOrderOfIdsEvenWhereSlotsWereUsedAgain) {
  const v1::Frame frame = Encoded(State({2, 1, 3, 1}), Everything());

  EXPECT_EQ(DecodeIds(frame.entity_ids()), (std::vector<EntityId>{{1, 1}, {3, 1}, {0, 2}, {2, 3}}));
  ExpectColumns<double>(frame, {1, 3, 0, 2});
}

TEST(WireFrame, ComesInSinglePrecisionOnRequest) {
  v1::FrameRequest request = Everything();
  request.set_scalar(v1::SCALAR_FLOAT32);

  const v1::Frame frame = Encoded(State({1, 1, 0}), request);

  EXPECT_EQ(frame.scalar(), v1::SCALAR_FLOAT32);
  ExpectColumns<float>(frame, {0, 1});
}

TEST(WireFrame, HasTheRequestedEntitiesOnceEachAndOnlyThoseThatLive) {
  v1::FrameRequest request = Everything();
  const EntityId stale(0, 7), null, forged = EntityId::FromPacked(uint64_t{1} << 32);
  for (const EntityId id : {EntityId(3, 1), EntityId(1, 1), stale, EntityId(3, 1), null, EntityId(9, 1), forged}) {
    request.add_entity_ids(id.packed());
  }

  const v1::Frame frame = Encoded(State({1, 1, 1, 1}), request);

  EXPECT_EQ(DecodeIds(frame.entity_ids()), (std::vector<EntityId>{{1, 1}, {3, 1}}));
  ExpectColumns<double>(frame, {1, 3});
}

TEST(WireFrame, IsEmptyWhenNoRequestedEntityLives) {
  v1::FrameRequest request = Everything();
  request.add_entity_ids(EntityId(9, 1).packed());

  const v1::Frame frame = Encoded(State({1, 1}), request);

  EXPECT_EQ(frame.entity_ids(), "");
  ExpectColumns<double>(frame, {});
}

TEST(WireFrame, HasNoColumnThatWasNotAskedFor) {
  const v1::Frame frame = Encoded(State({1, 1}), v1::FrameRequest());

  EXPECT_EQ(DecodeIds(frame.entity_ids()).size(), 2u);
  EXPECT_EQ(frame.asleep().size(), 1u);
  EXPECT_EQ(frame.positions() + frame.orientations() + frame.linear_velocities() + frame.angular_velocities() +
                frame.net_forces(),
            "");
}

TEST(WireFrame, TellsWhoSleepsBitByBitFromTheLowest) {
  StateArrays state = State({1, 1, 1, 1, 1, 1, 1, 1, 1, 1});
  state.asleep[1] = 1;
  state.asleep[8] = 1;

  EXPECT_EQ(Encoded(state, v1::FrameRequest()).asleep(), std::string("\x02\x01", 2));
}

TEST(WireFrame, NamesTheSetOfRows) {
  const v1::Frame frame = Encoded(State({1, 1, 1}), v1::FrameRequest());
  const v1::Frame same = Encoded(State({1, 1, 1, 0}), Everything());

  EXPECT_EQ(frame.rows_id(), same.rows_id());
  std::set<uint64_t> names{frame.rows_id()};
  for (const std::vector<uint32_t>& other : {std::vector<uint32_t>{1, 1}, {1, 1, 2}, {1, 1, 1, 1}, {0}}) {
    EXPECT_TRUE(names.insert(Encoded(State(other), v1::FrameRequest()).rows_id()).second);
  }
}

TEST(WireFrame, IsAKeyframeWithItsIdsEvenWhenDeltasAreWanted) {
  v1::FrameRequest request = Everything();
  request.set_deltas(true);

  const v1::Frame frame = Encoded(State({1, 1}), request);

  EXPECT_FALSE(frame.has_keyframe_step());
  EXPECT_EQ(DecodeIds(frame.entity_ids()).size(), 2u);
}

}  // namespace
}  // namespace genphys
