#include "genphys/hosting/stream_reply.h"

#include <string>
#include <utility>

#include "genphys/wire/error.h"
#include "genphys/wire/wire_format.h"

namespace genphys {

EncodedMessage EncodeOutcome(const ReplyFields& fields, const Result<EncodedMessage>& outcome) {
  std::string head;
  if (!outcome.ok()) {
    v1::Refusal refusal;
    EncodeRefusal(outcome.status(), &refusal);
    AppendField(fields.refusal, refusal.SerializeAsString(), head);
    return {MakeBytes(std::move(head))};
  }
  AppendFieldHeader(fields.response, SizeOf(*outcome), head);
  EncodedMessage message{MakeBytes(std::move(head))};
  message.insert(message.end(), outcome->begin(), outcome->end());
  return message;
}

}  // namespace genphys
