#include "step_replies.h"

#include <google/protobuf/io/coded_stream.h>
#include <grpcpp/support/proto_buffer_reader.h>

#include <utility>

namespace genphys::client {
namespace {

// A connection keeps no more than that for answers to come.
constexpr size_t kSpareMax = 2;
constexpr size_t kSpareBytesMax = 4 << 20;

}  // namespace

bool StepReply::Decode(grpc::ByteBuffer* bytes) {
  // To clear a message deletes those in it; to clear the frame by itself empties its columns and keeps their memory.
  if (message_.has_frame()) spare_.reset(message_.release_frame());
  message_.Clear();
  if (spare_ == nullptr) spare_ = std::make_unique<v1::Frame>();
  spare_->Clear();
  message_.set_allocated_frame(spare_.release());
  grpc::ProtoBufferReader reader(bytes);
  if (!reader.status().ok()) return false;
  google::protobuf::io::CodedInputStream stream(&reader);
  if (!message_.MergePartialFromCodedStream(&stream) || !stream.ConsumedEntireMessage()) return false;
  // Every frame says what its scalars are.
  if (message_.frame().scalar() == v1::SCALAR_UNSPECIFIED) spare_.reset(message_.release_frame());
  return true;
}

std::shared_ptr<StepReply> StepReplies::Take() {
  std::unique_ptr<StepReply> reply;
  {
    const std::lock_guard lock(mutex_);
    if (!spare_.empty()) {
      reply = std::move(spare_.back());
      spare_.pop_back();
    }
  }
  if (reply == nullptr) reply = std::make_unique<StepReply>();
  // A frame may outlive the connection that it came by.
  return {reply.release(), [replies = weak_from_this()](StepReply* done) {
            std::unique_ptr<StepReply> owned(done);
            if (const auto self = replies.lock()) self->GiveBack(std::move(owned));
          }};
}

void StepReplies::GiveBack(std::unique_ptr<StepReply> reply) {
  if (reply->message().ByteSizeLong() > kSpareBytesMax) return;
  const std::lock_guard lock(mutex_);
  if (spare_.size() < kSpareMax) spare_.push_back(std::move(reply));
}

}  // namespace genphys::client
