#pragma once
#include <memory>
#include <optional>

#include "genphys/client/streams.h"
#include "genphys/v1/simulation_service.pb.h"
#include "keyframes.h"
#include "resuming_stream.h"

namespace genphys::client {

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

  ResumingStream<v1::WatchEventsRequest, v1::WatchEventsResponse> stream_;
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
  ResumingStream<v1::WatchFramesRequest, v1::WatchFramesResponse> stream_;
  std::shared_ptr<v1::WatchFramesResponse> first_;
  FramePtr keyframe_;
};

}  // namespace genphys::client
