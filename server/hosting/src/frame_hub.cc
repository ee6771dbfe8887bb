#include "genphys/hosting/frame_hub.h"

#include <algorithm>
#include <utility>

#include "frame_subscription.h"
#include "genphys/wire/encode_frame.h"

namespace genphys {
namespace {

Bytes Encode(const World& world, const v1::FrameRequest& request, const Stamp& stamp) {
  v1::WorldStamp encoded_stamp;
  stamp.Encode(&encoded_stamp);
  const FrameEncoder frame(world, request, encoded_stamp);
  return MakeBytes(frame.size(), [&](char* to) { frame.Write(to); });
}

}  // namespace

FrameHub::FrameHub(WorkerPool& pool, std::function<void()> call_current)
    : pool_(pool), call_current_(std::move(call_current)) {}

bool FrameHub::HasViewers() const {
  const std::lock_guard lock(mutex_);
  return !layouts_.empty();
}

void FrameHub::Publish(const World& world, const Stamp& stamp) { Deliver(world, stamp, true); }

void FrameHub::PublishCurrent(const World& world, const Stamp& stamp) { Deliver(world, stamp, false); }

void FrameHub::Deliver(const World& world, const Stamp& stamp, bool is_new) {
  struct Order {
    const v1::FrameRequest* request;
    std::vector<std::shared_ptr<FrameSubscription>> takers;
  };
  std::vector<Order> orders;
  std::unique_lock lock(mutex_);
  for (auto layout = layouts_.begin(); layout != layouts_.end();) {
    std::erase_if(layout->viewers, [](const auto& viewer) { return viewer.expired(); });
    if (layout->viewers.empty()) {
      layout = layouts_.erase(layout);
      continue;
    }
    Order order{&layout->request, {}};
    for (const auto& weak : layout->viewers) {
      const auto viewer = weak.lock();
      if (viewer == nullptr) continue;
      if (is_new ? viewer->Offer(stamp.step) : viewer->WaitsForCurrent()) order.takers.push_back(viewer);
    }
    if (!order.takers.empty()) orders.push_back(std::move(order));
    ++layout;
  }
  lock.unlock();
  // Layouts stay where they are until the world comes here again, so their requests can be read without the lock.
  for (const Order& order : orders) {
    const Bytes frame = Encode(world, *order.request, stamp);
    lock.lock();
    for (const auto& viewer : order.takers) viewer->Take(frame);
    lock.unlock();
  }
}

void FrameHub::End(const Status& why) {
  const std::lock_guard lock(mutex_);
  if (end_) return;
  end_ = why;
  for (const Layout& layout : layouts_) {
    for (const auto& weak : layout.viewers) {
      const auto viewer = weak.lock();
      if (viewer == nullptr) continue;
      if (!viewer->end_) viewer->end_ = why;
      viewer->Settle();
    }
  }
}

std::shared_ptr<Subscription> FrameHub::Watch(Bytes request) {
  auto subscription = std::make_shared<FrameSubscription>(shared_from_this());
  pool_.Post([subscription, request = std::move(request)] { subscription->Open(request); });
  return subscription;
}

}  // namespace genphys
