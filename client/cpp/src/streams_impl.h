#pragma once
#include <memory>
#include <optional>
#include <utility>

#include "genphys/client/streams.h"
#include "genphys/v1/simulation_service.pb.h"
#include "keyframes.h"
#include "resuming_stream.h"

namespace genphys::client {

/// The newest frame, and what it is told against if it is a delta. All are read as soon as they are there: what nobody
/// reads waits in gRPC, and is old when it is read.
class NewestFrame {
 public:
  using Response = v1::WatchFramesResponse;
  struct Item {
    FramePtr received;
    FramePtr keyframe;
  };
  static constexpr bool kReadsOn = true;

  void Put(Response* received);
  void Take(Item* out) { *out = {std::exchange(newest_, nullptr), keyframe_}; }

 private:
  FramePtr newest_;    // null: it was taken
  FramePtr keyframe_;  // the last that came
};

class EventStream::Impl {
 public:
  Impl(std::shared_ptr<Connection> connection, v1::WatchEventsRequest request);

  /// Waits until the server has the subscription.
  Status Open(std::chrono::milliseconds timeout);
  Result<std::optional<EventBatch>> Next(std::optional<std::chrono::milliseconds> timeout);
  void Cancel() { stream_.Cancel(); }
  StreamPosition position() const { return position_; }

 private:
  Result<std::optional<EventBatch>> Take(const v1::WatchEventsResponse& response);

  ResumingStream<v1::WatchEventsRequest, EachMessage<v1::WatchEventsResponse>> stream_;
  StreamPosition position_;
  std::optional<v1::WatchEventsResponse> first_;  // came while opening and has news
};

class FrameStream::Impl {
 public:
  Impl(std::shared_ptr<Connection> connection, v1::WatchFramesRequest request);

  Status Open(std::chrono::milliseconds timeout);
  Result<std::optional<Frame>> Next(std::optional<std::chrono::milliseconds> timeout);
  void Cancel() { stream_.Cancel(); }

 private:
  ResumingStream<v1::WatchFramesRequest, NewestFrame> stream_;
  NewestFrame::Item first_;  // came while opening
};

}  // namespace genphys::client
