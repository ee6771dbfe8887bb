#include "transport.h"

#include <grpcpp/support/slice.h>

#include <memory>
#include <vector>

#include "genphys/wire/error.h"

namespace genphys {
namespace {

// Smaller pieces are copied: that costs less than sharing them.
constexpr size_t kSharedBytesMin = 512;

grpc::Slice ToSlice(const Bytes& bytes) {
  if (bytes.view.size() < kSharedBytesMin) return grpc::Slice(bytes.view.data(), bytes.view.size());
  // gRPC asks for bytes that could be written, and only reads them.
  return grpc::Slice(
      const_cast<char*>(bytes.view.data()), bytes.view.size(),
      [](void* owner) { delete static_cast<std::shared_ptr<const void>*>(owner); },
      new std::shared_ptr<const void>(bytes.owner));
}

}  // namespace

Bytes ToBytes(const grpc::ByteBuffer& buffer) {
  // On the heap before it is looked into, for a short slice holds its bytes itself.
  auto slice = std::make_shared<grpc::Slice>();
  if (!buffer.TrySingleSlice(slice.get()).ok() && !buffer.DumpToSingleSlice(slice.get()).ok()) return {};
  return {std::string_view(reinterpret_cast<const char*>(slice->begin()), slice->size()), slice};
}

grpc::ByteBuffer ToByteBuffer(const Bytes& bytes) {
  const grpc::Slice slice = ToSlice(bytes);
  return grpc::ByteBuffer(&slice, 1);
}

grpc::ByteBuffer ToByteBuffer(const EncodedMessage& message) {
  std::vector<grpc::Slice> slices;
  for (const Bytes& piece : message) slices.push_back(ToSlice(piece));
  return grpc::ByteBuffer(slices.data(), slices.size());
}

grpc::Status ToGrpcStatus(const Status& status) {
  if (status.ok()) return grpc::Status::OK;
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), MessageOf(status),
                      EncodeStatus(status).SerializeAsString());
}

}  // namespace genphys
