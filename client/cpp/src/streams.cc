#include "genphys/client/streams.h"

#include <utility>

#include "requests.h"
#include "streams_impl.h"

namespace genphys::client {
namespace {

using TimePoint = std::chrono::steady_clock::time_point;

std::optional<TimePoint> Until(std::optional<std::chrono::milliseconds> timeout) {
  if (!timeout) return std::nullopt;
  return std::chrono::steady_clock::now() + *timeout;
}

}  // namespace

EventStream::Impl::Impl(std::shared_ptr<Connection> connection, v1::WatchEventsRequest request)
    : stream_(std::move(connection), &v1::SimulationService::Stub::async::WatchEvents, std::move(request)) {}

Status EventStream::Impl::Open(std::chrono::milliseconds timeout) {
  v1::WatchEventsResponse response;
  const Result<bool> message = stream_.Next(&response, Until(timeout));
  if (!message.ok()) return message.status();
  if (!*message) return absl::UnavailableError("the subscription ended before it began");
  const bool has_news = response.has_gap() || response.batch().events_size() > 0;
  Result<std::optional<EventBatch>> batch = Take(response);
  if (!batch.ok()) return batch.status();
  if (has_news) first_ = std::move(response);
  return absl::OkStatus();
}

Result<std::optional<EventBatch>> EventStream::Impl::Take(const v1::WatchEventsResponse& response) {
  Result<std::vector<Event>> events = DecodeEvents(response.batch());
  if (!events.ok()) return events.status();
  EventBatch batch{.stamp = DecodeStamp(response.stamp()),
                   .events = *std::move(events),
                   .first_sequence = response.batch().first_sequence(),
                   .last_sequence = response.batch().last_sequence()};
  if (response.has_gap()) batch.gap = Gap{response.gap().first_sequence(), response.gap().last_sequence()};
  position_.epoch = batch.stamp.epoch;
  if (response.has_batch()) {
    position_.sequence = batch.last_sequence;
  } else if (batch.gap) {
    position_.sequence = batch.gap->last_sequence;
  }
  stream_.request().set_epoch(position_.epoch);
  stream_.request().set_after_sequence(position_.sequence);
  return std::optional<EventBatch>(std::move(batch));
}

Result<std::optional<EventBatch>> EventStream::Impl::Next(std::optional<std::chrono::milliseconds> timeout) {
  if (first_) return Take(*std::exchange(first_, std::nullopt));
  v1::WatchEventsResponse response;
  const Result<bool> message = stream_.Next(&response, Until(timeout));
  if (!message.ok()) return message.status();
  if (!*message) return std::optional<EventBatch>();
  return Take(response);
}

EventStream::EventStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EventStream::EventStream(EventStream&&) noexcept = default;
EventStream& EventStream::operator=(EventStream&&) noexcept = default;
EventStream::~EventStream() = default;

Result<std::optional<EventBatch>> EventStream::Next(std::optional<std::chrono::milliseconds> timeout) {
  return impl_->Next(timeout);
}

void EventStream::Cancel() { impl_->Cancel(); }

StreamPosition EventStream::position() const { return impl_->position(); }

void NewestFrame::Put(Response* received) {
  auto response = std::make_shared<Response>();
  response->Swap(received);
  v1::Frame& frame = *response->mutable_frame();
  if (newest_ != nullptr) frame.set_skipped_frames(frame.skipped_frames() + newest_->skipped_frames() + 1);
  newest_ = FramePtr(std::move(response), &frame);
  if (frame.keyframe_id() != 0 && !frame.has_keyframe_step()) keyframe_ = newest_;
}

FrameStream::Impl::Impl(std::shared_ptr<Connection> connection, v1::WatchFramesRequest request)
    : stream_(std::move(connection), &v1::SimulationService::Stub::async::WatchFrames, std::move(request)) {}

Status FrameStream::Impl::Open(std::chrono::milliseconds timeout) {
  const Result<bool> came = stream_.Next(&first_, Until(timeout));
  if (!came.ok()) return came.status();
  if (!*came) return absl::UnavailableError("the subscription ended before it began");
  return absl::OkStatus();
}

Result<std::optional<Frame>> FrameStream::Impl::Next(std::optional<std::chrono::milliseconds> timeout) {
  NewestFrame::Item item = std::exchange(first_, {});
  if (item.received == nullptr) {
    const Result<bool> came = stream_.Next(&item, Until(timeout));
    if (!came.ok()) return came.status();
    if (!*came) return std::optional<Frame>();
  }
  Result<FramePtr> whole = WholeFrame(std::move(item.received), item.keyframe);
  if (!whole.ok()) return whole.status();
  Result<Frame> frame = Frame::Make(*std::move(whole));
  if (!frame.ok()) return frame.status();
  return std::optional<Frame>(*std::move(frame));
}

FrameStream::FrameStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FrameStream::FrameStream(FrameStream&&) noexcept = default;
FrameStream& FrameStream::operator=(FrameStream&&) noexcept = default;
FrameStream::~FrameStream() = default;

Result<std::optional<Frame>> FrameStream::Next(std::optional<std::chrono::milliseconds> timeout) {
  return impl_->Next(timeout);
}

void FrameStream::Cancel() { impl_->Cancel(); }

}  // namespace genphys::client
