#pragma once
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include "genphys/hosting/bytes.h"
#include "genphys/status.h"

namespace genphys {

/// The bytes of `buffer`, without copying if they lie in one piece.
Bytes ToBytes(const grpc::ByteBuffer& buffer);

/// A buffer of `bytes`, which it keeps alive instead of copying them.
grpc::ByteBuffer ToByteBuffer(const Bytes& bytes);
grpc::ByteBuffer ToByteBuffer(const EncodedMessage& message);

/// Code, message, and the refusal as google.rpc.Status in the details.
grpc::Status ToGrpcStatus(const Status& status);

}  // namespace genphys
