#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "genphys/hosting/event_log.h"
#include "genphys/v1/simulation_service.pb.h"

namespace genphys {

/// A cursor into an EventLog. The log's mutex guards its state; messages are encoded without it.
class EventSubscription final : public Subscription, public std::enable_shared_from_this<EventSubscription> {
 public:
  explicit EventSubscription(std::shared_ptr<EventLog> log) : log_(std::move(log)) {}

  /// Decodes the request and takes the place that it asks for; a bad one ends the stream.
  void Open(const Bytes& request);

  void Next(Receiver receiver) override;
  void Cancel() override;

 private:
  friend class EventLog;

  // A message about lost history, sent before the events that are left.
  struct Notice {
    Stamp stamp;
    std::optional<std::pair<uint64_t, uint64_t>> gap;  // first and last number lost; else:
    std::vector<Event> touching;                       // the pairs that touched after them
    uint64_t next_sequence = 0;
  };
  // What one message is made of, taken with the lock held and encoded without it.
  struct Draft {
    std::optional<Notice> notice;  // else a batch
    Stamp now;
    uint64_t first_sequence = 0;
    std::vector<std::shared_ptr<const EventChunk>> chunks;
    bool must_send = false;  // even with no event in it
  };
  struct Batch {
    EncodedMessage message;
    uint64_t last_sequence = 0;
    bool has_events = false;
  };

  // These are called with the log's mutex held.
  Status TakePlace(const v1::WatchEventsRequest& request);
  void Wake();
  bool HasWork() const;
  std::optional<Status> End() const;
  void FollowNewEpoch(const EventLog::PastEpoch& past);
  void LoseHistory();
  Draft TakeDraft();
  void Advance(const Draft& draft, uint64_t last_sequence, bool sent);
  void ArmBookmark();

  void Serve();
  // False when there is nothing more to do for now.
  bool ServeOne();
  void GiveUp(const Status& why);
  static EncodedMessage EncodeNotice(const Notice& notice);
  Batch EncodeBatch(const Draft& draft) const;

  const std::shared_ptr<EventLog> log_;
  EventFilter filter_;  // constant once open
  bool open_ = false;
  bool serving_ = false;   // a worker is at it, or will be
  bool encoding_ = false;  // a draft was taken, and what became of it is not known yet
  std::optional<Status> end_;
  Receiver receiver_;     // set: somebody waits
  uint64_t cursor_ = 1;   // number of the next event to look at
  uint64_t told_ = 0;     // last number that the subscriber knows to have been looked at
  bool greeted_ = false;  // it has had a message of this epoch
  bool bookmark_due_ = false;
  bool bookmark_armed_ = false;
  std::optional<EventLog::PastEpoch> left_while_encoding_;
  std::deque<Notice> notices_;
};

}  // namespace genphys
