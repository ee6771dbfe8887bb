#include "genphys/wire/early_end.h"

#include <charconv>
#include <string>

#include "absl/strings/cord.h"
#include "absl/types/optional.h"
#include "early_end_message.h"

namespace genphys {
namespace {

// The bytes of a v1::EarlyEnd.
constexpr char kEarlyEndUrl[] = "genphys/early_end";

// A batch has no more commands, so that no text makes a client allocate what it likes.
constexpr uint64_t kCommandsMax = 100'000;

CreatedId IdOf(uint64_t packed) { return EntityId::FromPacked(packed); }

// Takes a number from the beginning of `text`.
std::optional<uint64_t> TakeNumber(std::string_view& text) {
  uint64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<size_t>(read.ptr - text.data()));
  return number;
}

bool Take(char expected, std::string_view& text) {
  if (!text.starts_with(expected)) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

Status WithEarlyEnd(Status status, const EarlyEnd& end) {
  v1::EarlyEnd message;
  EncodeEarlyEnd(end, &message);
  status.SetPayload(kEarlyEndUrl, absl::Cord(message.SerializeAsString()));
  return status;
}

std::optional<EarlyEnd> EarlyEndOf(const Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kEarlyEndUrl);
  v1::EarlyEnd message;
  if (!payload || !message.ParseFromString(std::string(*payload))) return std::nullopt;
  return DecodeEarlyEnd(message);
}

void EncodeEarlyEnd(const EarlyEnd& end, v1::EarlyEnd* out) {
  out->set_steps_done(end.steps_done);
  out->set_step(end.step);
  if (end.commands_done) out->set_commands_done(*end.commands_done);
  for (const CreatedId id : end.created) out->add_created_ids(id.packed());
}

EarlyEnd DecodeEarlyEnd(const v1::EarlyEnd& message) {
  EarlyEnd end{message.steps_done(), message.step()};
  if (message.has_commands_done()) end.commands_done = message.commands_done();
  for (const uint64_t id : message.created_ids()) end.created.push_back(IdOf(id));
  return end;
}

std::optional<std::string> CreatedText(std::span<const CreatedId> created) {
  std::string text;
  for (size_t i = 0; i < created.size();) {
    const uint64_t first = created[i].packed();
    if (first == 0) {
      ++i;
      continue;
    }
    size_t end = i + 1;
    while (end < created.size() && created[end].packed() == first + (end - i)) ++end;
    if (!text.empty()) text += ' ';
    text += std::to_string(i) + ':' + std::to_string(first);
    if (end > i + 1) text += '-' + std::to_string(created[end - 1].packed());
    if (text.size() > kCreatedTextMax) return std::nullopt;
    i = end;
  }
  return text;
}

std::vector<CreatedId> CreatedOf(std::string_view text) {
  std::vector<CreatedId> created;
  while (!text.empty()) {
    const std::optional<uint64_t> command = TakeNumber(text);
    if (!command || *command < created.size() || !Take(':', text)) return {};
    const std::optional<uint64_t> first = TakeNumber(text);
    std::optional<uint64_t> last = first;
    if (Take('-', text)) last = TakeNumber(text);
    if (!first || !last || *last < *first || *command >= kCommandsMax || *last - *first >= kCommandsMax) return {};
    created.resize(*command);
    for (uint64_t id = *first; id <= *last; ++id) created.push_back(IdOf(id));
    if (!text.empty() && !Take(' ', text)) return {};
  }
  return created;
}

}  // namespace genphys
