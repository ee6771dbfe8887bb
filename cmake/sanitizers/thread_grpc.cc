// Teaches the thread sanitizer how gRPC hands work from one thread to another; linked into every program of a
// thread-sanitizer build and into nothing else.
//
// Debian's gRPC and abseil are not instrumented, so the sanitizer sees neither their locks nor their atomics: every
// request that a reactor hands to a worker would be reported as a race. Suppressing reports with gRPC in their stack
// would hide our own races too, because gRPC is at the bottom of every reactor's stack. Instead, each function below
// stands before the library's function of the same name, calls it, and declares the order that it really establishes.
// Together with ignoring what only the libraries touch, this needs no suppressions.
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <dlfcn.h>
#include <grpc/grpc.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/support/callback_common.h>
#include <sanitizer/tsan_interface.h>

#include <cstdio>
#include <cstdlib>

namespace {

// The library's own function, which the one of this file stands before.
template <typename Function>
Function* Original(const char* symbol) {
  void* found = dlsym(RTLD_NEXT, symbol);
  if (found == nullptr) {
    std::fprintf(stderr, "thread_grpc.cc: the gRPC or abseil library has no %s\n", symbol);
    std::abort();
  }
  return reinterpret_cast<Function*>(found);
}

}  // namespace

extern "C" const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1:second_deadlock_stack=1"; }

// abseil's mutex and condition variable, on which all of gRPC's locks are built.
namespace absl {

void Mutex::Lock() {
  static auto* const original = Original<void(Mutex*)>("_ZN4absl7debian35Mutex4LockEv");
  original(this);
  __tsan_acquire(this);
}

bool Mutex::TryLock() {
  static auto* const original = Original<bool(Mutex*)>("_ZN4absl7debian35Mutex7TryLockEv");
  const bool locked = original(this);
  if (locked) __tsan_acquire(this);
  return locked;
}

void Mutex::Unlock() {
  static auto* const original = Original<void(Mutex*)>("_ZN4absl7debian35Mutex6UnlockEv");
  __tsan_release(this);
  original(this);
}

void ReleasableMutexLock::Release() {
  static auto* const original = Original<void(ReleasableMutexLock*)>("_ZN4absl7debian319ReleasableMutexLock7ReleaseEv");
  // Its only member is the mutex.
  __tsan_release(*reinterpret_cast<Mutex**>(this));
  original(this);
}

void CondVar::Wait(Mutex* mutex) {
  static auto* const original = Original<void(CondVar*, Mutex*)>("_ZN4absl7debian37CondVar4WaitEPNS0_5MutexE");
  __tsan_release(mutex);
  original(this, mutex);
  __tsan_acquire(mutex);
}

bool CondVar::WaitWithTimeout(Mutex* mutex, Duration timeout) {
  static auto* const original = Original<bool(CondVar*, Mutex*, Duration)>(
      "_ZN4absl7debian37CondVar15WaitWithTimeoutEPNS0_5MutexENS0_8DurationE");
  __tsan_release(mutex);
  const bool timed_out = original(this, mutex, timeout);
  __tsan_acquire(mutex);
  return timed_out;
}

bool CondVar::WaitWithDeadline(Mutex* mutex, Time deadline) {
  static auto* const original =
      Original<bool(CondVar*, Mutex*, Time)>("_ZN4absl7debian37CondVar16WaitWithDeadlineEPNS0_5MutexENS0_4TimeE");
  __tsan_release(mutex);
  const bool timed_out = original(this, mutex, deadline);
  __tsan_acquire(mutex);
  return timed_out;
}

}  // namespace absl

// An explicit instantiation may name private members: the only way to what gRPC's headers keep to themselves.
namespace {

template <typename Tag, void (Tag::*run)(bool)>
struct RunAccess {
  friend void RunTag(Tag* tag, bool ok) { (tag->*run)(ok); }
};
void RunTag(grpc::internal::CallbackWithSuccessTag* tag, bool ok);
void RunTag(grpc::internal::CallbackWithStatusTag* tag, bool ok);
template struct RunAccess<grpc::internal::CallbackWithSuccessTag, &grpc::internal::CallbackWithSuccessTag::Run>;
template struct RunAccess<grpc::internal::CallbackWithStatusTag, &grpc::internal::CallbackWithStatusTag::Run>;

template <auto member>
struct ReferencesAccess {
  friend void* ReferencesOf(grpc::internal::ServerCallbackCall* call) { return &(call->*member); }
};
void* ReferencesOf(grpc::internal::ServerCallbackCall* call);
template struct ReferencesAccess<&grpc::internal::ServerCallbackCall::callbacks_outstanding_>;

// Stands for the memory of all calls: what the last call did with it comes before what the next one does.
char call_memory;

}  // namespace

// A batch of operations is started on one thread, and its callback runs on another. The header defines the callbacks'
// entry inline, so the linker prefers these.
void EnterSuccessCallback(grpc_completion_queue_functor* tag, int ok) asm(
    "_ZN4grpc8internal22CallbackWithSuccessTag9StaticRunEP29grpc_completion_queue_functori");
void EnterSuccessCallback(grpc_completion_queue_functor* tag, int ok) {
  __tsan_acquire(tag);
  RunTag(static_cast<grpc::internal::CallbackWithSuccessTag*>(tag), ok != 0);
}

void EnterStatusCallback(grpc_completion_queue_functor* tag, int ok) asm(
    "_ZN4grpc8internal21CallbackWithStatusTag9StaticRunEP29grpc_completion_queue_functori");
void EnterStatusCallback(grpc_completion_queue_functor* tag, int ok) {
  __tsan_acquire(tag);
  RunTag(static_cast<grpc::internal::CallbackWithStatusTag*>(tag), ok != 0);
}

extern "C" {

grpc_call_error grpc_call_start_batch(grpc_call* call, const grpc_op* operations, size_t count, void* tag,
                                      void* reserved) {
  static auto* const original =
      Original<grpc_call_error(grpc_call*, const grpc_op*, size_t, void*, void*)>("grpc_call_start_batch");
  __tsan_release(tag);
  return original(call, operations, count, tag, reserved);
}

void* grpc_call_arena_alloc(grpc_call* call, size_t size) {
  static auto* const original = Original<void*(grpc_call*, size_t)>("grpc_call_arena_alloc");
  void* const memory = original(call, size);
  __tsan_acquire(&call_memory);
  return memory;
}

void grpc_call_unref(grpc_call* call) {
  static auto* const original = Original<void(grpc_call*)>("grpc_call_unref");
  __tsan_release(&call_memory);
  original(call);
}

}  // extern "C"

// The last reference to a call may be dropped inside the library, where the count is not seen to be atomic.
void grpc::internal::ServerCallbackCall::ScheduleOnDone(bool inline_ondone) {
  static auto* const original =
      Original<void(ServerCallbackCall*, bool)>("_ZN4grpc8internal18ServerCallbackCall14ScheduleOnDoneEb");
  __tsan_acquire(ReferencesOf(this));
  original(this, inline_ondone);
}
