#include "genphys/hosting/stream_reply.h"

#include <string>
#include <utility>

#include "genphys/wire/error.h"
#include "genphys/wire/wire_format.h"

namespace genphys {

EncodedMessage EncodeOutcome(const ReplyFields& fields, const Result<Bytes>& outcome) {
  std::string head;
  if (!outcome.ok()) {
    v1::Refusal refusal;
    EncodeRefusal(outcome.status(), &refusal);
    AppendField(fields.refusal, refusal.SerializeAsString(), head);
    return {MakeBytes(std::move(head))};
  }
  AppendFieldHeader(fields.response, outcome->view.size(), head);
  return {MakeBytes(std::move(head)), *outcome};
}

size_t SizeOf(const EncodedMessage& message) {
  size_t size = 0;
  for (const Bytes& piece : message) size += piece.view.size();
  return size;
}

}  // namespace genphys
