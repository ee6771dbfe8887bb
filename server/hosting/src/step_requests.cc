#include "step_requests.h"

#include <algorithm>
#include <utility>

#include "genphys/hosting/request_head.h"
#include "genphys/hosting/world_methods.h"

namespace genphys {

Result<std::shared_ptr<const v1::StepRequest>> StepRequests::Decode(const Bytes& request) {
  if (RepeatsLast(request.view)) return last_;
  auto message = std::make_shared<v1::StepRequest>();
  GENPHYS_RETURN_IF_ERROR(DecodeRequest(request, message.get()));
  Keep(request.view, message);
  return std::shared_ptr<const v1::StepRequest>(std::move(message));
}

// What comes before an id tells where it ends, so that of equal bytes around it nothing else can be meant.
bool StepRequests::RepeatsLast(std::string_view request) const {
  if (last_ == nullptr || request.size() != bytes_.size()) return false;
  const std::string_view last = bytes_;
  const std::string_view id = request.substr(id_begin_, id_end_ - id_begin_);
  // Any text of the same length is within the limits of an id. What is not ASCII may be no text.
  const bool is_text = std::all_of(id.begin(), id.end(), [](char c) { return static_cast<signed char>(c) >= 0; });
  return is_text && request.substr(0, id_begin_) == last.substr(0, id_begin_) &&
         request.substr(id_end_) == last.substr(id_end_);
}

void StepRequests::Keep(std::string_view request, std::shared_ptr<const v1::StepRequest> message) {
  last_ = nullptr;
  const std::optional<RequestHead> head = ScanRequestHead(InfoOf(WorldMethod::kStep).head, request);
  if (!head || head->has_commands || request.size() > kBytesMax) return;
  bytes_ = request;
  id_begin_ = head->request_id.empty() ? 0 : static_cast<size_t>(head->request_id.data() - request.data());
  id_end_ = id_begin_ + head->request_id.size();
  last_ = std::move(message);
}

}  // namespace genphys
