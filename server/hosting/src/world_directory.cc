#include "genphys/hosting/world_directory.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <new>
#include <optional>
#include <random>
#include <utility>

#include "genphys/hosting/step_worlds_call.h"
#include "genphys/hosting/world_methods.h"
#include "genphys/v1/simulation_service.pb.h"
#include "page_token.h"

namespace genphys {
namespace {

constexpr std::string_view kNamePrefix = "worlds/";
constexpr std::string_view kCreateWorld = "genphys.v1.WorldService.CreateWorld";

Status Draining() { return Refuse(Reason::kDraining, "", "the server is shutting down"); }

std::string GeneratedName() {
  constexpr std::string_view kLetters = "0123456789abcdefghijklmnopqrstuvwxyz";
  constexpr int kLength = 8;
  std::random_device device;
  std::uniform_int_distribution<size_t> any(0, kLetters.size() - 1);
  std::string name = std::string(kNamePrefix) + "w-";
  for (int i = 0; i < kLength; ++i) name += kLetters[any(device)];
  return name;
}

// The requests of a StepWorldsRequest, which keep its bytes alive.
Result<std::vector<Bytes>> RequestsOf(const Bytes& request) {
  constexpr int kField = v1::StepWorldsRequest::kRequestsFieldNumber;
  static const uint64_t requests_max =
      v1::StepWorldsRequest::descriptor()->FindFieldByNumber(kField)->options().GetExtension(v1::limit).max_items();
  const auto payloads = ScanPayloads(kField, request.view);
  if (!payloads) return Refuse(Reason::kInvalidValue, "", "the bytes sent are no genphys.v1.StepWorldsRequest");
  if (payloads->empty()) return Refuse(Reason::kMissingField, "requests", "requests must not be empty");
  if (payloads->size() > requests_max) {
    return Refuse(Reason::kOutOfRange, "requests",
                  "requests must have at most " + std::to_string(requests_max) + " elements, has " +
                      std::to_string(payloads->size()));
  }
  std::vector<Bytes> requests;
  for (const std::string_view payload : *payloads) requests.push_back({payload, request.owner});
  return requests;
}

// A stream that never was.
class EndedSubscription final : public Subscription {
 public:
  EndedSubscription(WorkerPool& pool, Status why) : pool_(pool), why_(std::move(why)) {}
  void Next(Receiver receiver) override {
    pool_.Post([receiver = std::move(receiver), why = why_] { receiver({std::nullopt, why}); });
  }
  void Cancel() override {}

 private:
  WorkerPool& pool_;
  const Status why_;
};

}  // namespace

// A CreateWorld under way, and everybody who waits for it.
struct WorldDirectory::Creation {
  Bytes encoded;
  uint64_t fingerprint = 0;
  v1::CreateWorldRequest request;
  WorldKey key;
  std::vector<Reply> waiting;
};

// A page of ListWorlds, filled by its worlds in any order.
struct WorldDirectory::Page {
  std::mutex mutex;
  std::vector<std::optional<v1::GetWorldResponse>> worlds;
  size_t missing = 0;
  std::string next_page_token;
  Reply reply;

  void Send() const {
    v1::ListWorldsResponse response;
    for (const auto& world : worlds) {
      if (!world) continue;  // deleted meanwhile
      *response.add_worlds() = world->world();
      *response.add_stamps() = world->stamp();
    }
    response.set_next_page_token(next_page_token);
    reply(EncodedMessage{EncodeReply(response)});
  }
};

WorldDirectory::WorldDirectory(WorkerPool& pool, HostFactory make_host, size_t worlds_max)
    : pool_(pool), make_host_(std::move(make_host)), worlds_max_(worlds_max), memory_return_(pool) {}

std::shared_ptr<WorldHost> WorldDirectory::Find(const WorldKey& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = worlds_.find(key);
  return found == worlds_.end() ? nullptr : found->second;
}

void WorldDirectory::Create(Bytes request, Reply reply) {
  if (draining_) return reply(Draining());
  auto creation = std::make_shared<Creation>();
  creation->encoded = std::move(request);
  creation->waiting.push_back(std::move(reply));
  pool_.Post([this, creation] {
    try {
      MakeWorld(creation);
    } catch (const std::exception& exception) {
      Unreserve(creation->key);
      FinishCreation(creation, absl::InternalError(std::string("the world cannot be made: ") + exception.what()));
    }
  });
}

void WorldDirectory::MakeWorld(const std::shared_ptr<Creation>& creation) {
  if (const Status status = DecodeRequest(creation->encoded, &creation->request); !status.ok()) {
    return creation->waiting.front()(status);
  }
  if (Repeats(creation)) return;
  if (const Status status = Reserve(*creation); !status.ok()) return FinishCreation(creation, status);
  const Result<std::shared_ptr<WorldHost>> host = make_host_(creation->key.name, creation->request.world());
  if (!host.ok()) {
    Unreserve(creation->key);
    return FinishCreation(creation, host.status());
  }
  {
    const std::lock_guard lock(mutex_);
    worlds_[creation->key] = *host;
  }
  spdlog::debug("{} created", creation->key.name);
  if (draining_) (*host)->Drain(Draining());
  // The reply to GetWorld has the fields of the reply to CreateWorld under the same numbers.
  WorldCall get{.method = WorldMethod::kGetWorld};
  v1::GetWorldRequest get_request;
  get_request.set_name(creation->key.name);
  get.request = EncodeReply(get_request);
  (*host)->Handle(std::move(get),
                  [this, creation](const Result<EncodedMessage>& world) { FinishCreation(creation, world); });
}

bool WorldDirectory::Repeats(const std::shared_ptr<Creation>& creation) {
  const std::string& id = creation->request.request_id();
  if (id.empty()) return false;
  creation->fingerprint = ReplyCache::Fingerprint(kCreateWorld, creation->encoded.view);
  std::unique_lock lock(mutex_);
  std::optional<Result<EncodedMessage>> outcome = created_.Find(id, creation->fingerprint);
  if (!outcome) {
    const auto [other, is_first] = being_created_.try_emplace(id, creation);
    if (is_first) return false;
    if (other->second->fingerprint == creation->fingerprint) {
      other->second->waiting.push_back(std::move(creation->waiting.front()));
      return true;
    }
    outcome = Refuse(Reason::kInvalidValue, "request_id", "request_id was used for another request before");
  }
  lock.unlock();
  creation->waiting.front()(*outcome);
  return true;
}

Status WorldDirectory::Reserve(Creation& creation) {
  const std::lock_guard lock(mutex_);
  if (worlds_.size() >= worlds_max_) {
    return Refuse(Reason::kLimitExceeded, "",
                  "this server hosts no more than " + std::to_string(worlds_max_) + " worlds: delete one first");
  }
  const std::string& name = creation.request.world().name();
  do {
    creation.key.name = name.empty() ? GeneratedName() : name;
  } while (name.empty() && worlds_.contains(creation.key));
  if (worlds_.try_emplace(creation.key, nullptr).second) return absl::OkStatus();
  return Refuse(Reason::kAlreadyExists, "world.name", "there is a world " + name + " already");
}

void WorldDirectory::Unreserve(const WorldKey& key) {
  const std::lock_guard lock(mutex_);
  const auto reserved = worlds_.find(key);
  if (reserved != worlds_.end() && reserved->second == nullptr) worlds_.erase(reserved);
}

void WorldDirectory::FinishCreation(const std::shared_ptr<Creation>& creation, const Result<EncodedMessage>& outcome) {
  std::vector<Reply> waiting;
  {
    const std::lock_guard lock(mutex_);
    const std::string& id = creation->request.request_id();
    if (!id.empty()) {
      if (outcome.ok()) created_.Keep(id, creation->fingerprint, outcome);
      const auto under_way = being_created_.find(id);
      if (under_way != being_created_.end() && under_way->second == creation) being_created_.erase(under_way);
    }
    waiting.swap(creation->waiting);
  }
  for (const Reply& reply : waiting) reply(outcome);
}

// Here and now, for all workers may be in long steps.
void WorldDirectory::List(const Bytes& request, const Reply& reply) {
  if (draining_) return reply(Draining());
  try {
    ListPage(request, reply);
  } catch (const std::bad_alloc&) {
    reply(Refuse(Reason::kLimitExceeded, "", "there is not enough memory for this request"));
  } catch (const std::exception& exception) {
    // Nothing may leave: this is a thread of gRPC's, which would end the program.
    reply(absl::InternalError(std::string("the request failed: ") + exception.what()));
  }
}

void WorldDirectory::ListPage(const Bytes& encoded, const Reply& reply) {
  v1::ListWorldsRequest request;
  if (const Status status = DecodeRequest(encoded, &request); !status.ok()) return reply(status);
  WorldKey place;
  if (!request.page_token().empty()) {
    const std::optional<std::string> name = DecodePageToken(request.page_token());
    if (!name || !name->starts_with(kNamePrefix)) {
      return reply(Refuse(Reason::kInvalidValue, "page_token", "page_token is none of this server's"));
    }
    place.name = *name;
  }
  std::vector<std::pair<std::string, std::shared_ptr<WorldHost>>> found;
  auto page = std::make_shared<Page>();
  page->reply = reply;
  const size_t count = PageSize(request.page_size());
  {
    const std::lock_guard lock(mutex_);
    for (auto world = worlds_.upper_bound(place); world != worlds_.end(); ++world) {
      if (world->second == nullptr) continue;
      if (found.size() == count) {
        page->next_page_token = EncodePageToken(found.back().first);
        break;
      }
      found.emplace_back(world->first.name, world->second);
    }
  }
  if (found.empty()) return page->Send();
  page->worlds.resize(found.size());
  page->missing = found.size();
  for (size_t i = 0; i < found.size(); ++i) {
    WorldCall get{.method = WorldMethod::kGetWorld};
    v1::GetWorldRequest get_request;
    get_request.set_name(found[i].first);
    get.request = EncodeReply(get_request);
    found[i].second->Handle(std::move(get), [page, i](const Result<EncodedMessage>& world) {
      v1::GetWorldResponse response;
      const bool good = world.ok() && response.ParseFromString(Joined(*world));
      bool is_last;
      {
        const std::lock_guard lock(page->mutex);
        if (good) page->worlds[i] = std::move(response);
        is_last = --page->missing == 0;
      }
      if (is_last) page->Send();
    });
  }
}

Status WorldDirectory::Unknown(const WorldCall& call) const {
  GENPHYS_RETURN_IF_ERROR(CheckRequest(call.method, call.request));
  const std::optional<RequestHead> head = ScanRequestHead(InfoOf(call.method).head, call.request.view);
  if (!head) return Refuse(Reason::kInvalidValue, "", "the bytes sent are no request");
  const bool by_name = call.method <= WorldMethod::kPauseWorld;
  return Refuse(Reason::kWorldNotFound, by_name ? "name" : "world", "there is no world " + std::string(head->world));
}

void WorldDirectory::Handle(WorldCall call, Reply reply) {
  if (draining_) return reply(Draining());
  call.is_over = is_over_;
  std::shared_ptr<WorldHost> host;
  if (const auto head = ScanRequestHead(InfoOf(call.method).head, call.request.view)) {
    const WorldKey key{"", std::string(head->world)};
    call.request_id = head->request_id;
    call.has_commands = head->has_commands;
    if (call.method == WorldMethod::kDeleteWorld) {
      const std::lock_guard lock(mutex_);
      const auto found = worlds_.find(key);
      if (found != worlds_.end() && found->second != nullptr) {
        host = std::move(found->second);
        worlds_.erase(found);
        memory_return_.Note();
        spdlog::debug("{} deleted", key.name);
      }
    } else {
      host = Find(key);
    }
  }
  if (host != nullptr) return host->Handle(std::move(call), std::move(reply));
  pool_.Post([this, call = std::move(call), reply = std::move(reply)] { reply(Unknown(call)); });
}

std::shared_ptr<Subscription> WorldDirectory::Watch(WorldMethod method, Bytes request) {
  if (draining_) return std::make_shared<EndedSubscription>(pool_, Draining());
  WorldCall call{.method = method, .request = std::move(request)};
  const auto head = ScanRequestHead(InfoOf(method).head, call.request.view);
  const std::shared_ptr<WorldHost> host = head ? Find({"", std::string(head->world)}) : nullptr;
  if (host == nullptr) return std::make_shared<EndedSubscription>(pool_, Unknown(call));
  return host->Watch(method, std::move(call.request));
}

// What the reply to an encoded StepRequest will take, or a little less than that: nobody knows yet what will happen.
size_t WorldDirectory::StepReplyBytes(const Bytes& request) const {
  constexpr size_t kHead = 1024;          // without frame and events
  constexpr size_t kEvents = 64 << 10;    // a guess
  constexpr size_t kCommandBytesMin = 4;  // of one that creates
  constexpr size_t kCommandsMax = 100'000;
  constexpr size_t kIdBytes = 12;
  constexpr size_t kRowBytes = 200;  // of a frame, with whatever a command creates
  const std::string_view bytes = request.view;
  const auto head = ScanRequestHead(InfoOf(WorldMethod::kStep).head, bytes);
  if (!head) return kHead;
  const auto asks_for = [&](int number) { return !ScanPayloads(static_cast<uint32_t>(number), bytes)->empty(); };
  const size_t commands = head->has_commands ? std::min(bytes.size() / kCommandBytesMin, kCommandsMax) : 0;
  size_t size = kHead + commands * kIdBytes;
  if (asks_for(v1::StepRequest::kEventsFieldNumber)) size += kEvents;
  if (asks_for(v1::StepRequest::kFrameFieldNumber)) {
    const std::shared_ptr<WorldHost> host = Find({"", std::string(head->world)});
    if (host != nullptr) size += host->frame_bytes_max() + commands * kRowBytes;
  }
  return size;
}

std::shared_ptr<Subscription> WorldDirectory::StepWorlds(const Bytes& request,
                                                         std::chrono::steady_clock::time_point deadline) {
  if (draining_) return std::make_shared<EndedSubscription>(pool_, Draining());
  Result<std::vector<Bytes>> requests = RequestsOf(request);
  if (!requests.ok()) return std::make_shared<EndedSubscription>(pool_, requests.status());
  auto call = std::make_shared<StepWorldsCall>(
      *std::move(requests), deadline, pool_,
      [this](WorldCall step, Reply reply) { Handle(std::move(step), std::move(reply)); },
      [this](const Bytes& step) { return StepReplyBytes(step); });
  call->Begin();
  return call;
}

std::shared_ptr<Drive> WorldDirectory::OpenDrive(std::chrono::steady_clock::time_point deadline) {
  auto drive = std::make_shared<Drive>(
      deadline, pool_, [this](WorldCall step, Reply reply) { Handle(std::move(step), std::move(reply)); });
  {
    const std::lock_guard lock(mutex_);
    drives_.remove_if([](const auto& other) { return other.expired(); });
    drives_.push_back(drive);
  }
  if (draining_) drive->End(Draining());
  return drive;
}

void WorldDirectory::Drain() {
  draining_ = true;
  std::vector<std::shared_ptr<WorldHost>> hosts;
  std::list<std::weak_ptr<Drive>> drives;
  {
    const std::lock_guard lock(mutex_);
    drives.swap(drives_);
    for (const auto& [key, host] : worlds_) {
      if (host != nullptr) hosts.push_back(host);
    }
  }
  for (const auto& host : hosts) host->Drain(Draining());
  for (const auto& weak : drives) {
    if (const auto drive = weak.lock()) drive->End(Draining());
  }
}

}  // namespace genphys
