#include "genphys/hosting/world_methods.h"

#include <google/protobuf/descriptor.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"
#include "genphys/wire/validate_limits.h"

namespace genphys {
namespace {

// By the number of the method.
constexpr std::array<std::string_view, 21> kNames{
    "genphys.v1.WorldService.GetWorld",          "genphys.v1.WorldService.DeleteWorld",
    "genphys.v1.WorldService.ResetWorld",        "genphys.v1.WorldService.PlayWorld",
    "genphys.v1.WorldService.PauseWorld",        "genphys.v1.SimulationService.CreateEntity",
    "genphys.v1.SimulationService.DeleteEntity", "genphys.v1.SimulationService.ApplyForce",
    "genphys.v1.SimulationService.GetEntity",    "genphys.v1.SimulationService.ListEntities",
    "genphys.v1.SimulationService.ListJoints",   "genphys.v1.SimulationService.ListForceFields",
    "genphys.v1.SimulationService.Step",         "genphys.v1.SimulationService.CastRays",
    "genphys.v1.SimulationService.CastShape",    "genphys.v1.SimulationService.FindOverlaps",
    "genphys.v1.SimulationService.FindClosest",  "genphys.v1.SimulationService.MeasureDistances",
    "genphys.v1.SimulationService.GetContacts",  "genphys.v1.SimulationService.WatchEvents",
    "genphys.v1.SimulationService.WatchFrames"};
static_assert(kNames.size() == static_cast<size_t>(WorldMethod::kWatchFrames) + 1, "one name per method");

std::array<WorldMethodInfo, kNames.size()> ReadContract() {
  // A file is known to the pool once its code is linked, which the names alone do not bring about.
  v1::StepRequest::descriptor();
  v1::GetWorldRequest::descriptor();
  std::array<WorldMethodInfo, kNames.size()> infos;
  for (size_t i = 0; i < infos.size(); ++i) {
    infos[i].name = kNames[i];
    infos[i].request =
        google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(std::string(kNames[i]))->input_type();
    infos[i].head = RequestHeadFields::Of(*infos[i].request);
  }
  return infos;
}

}  // namespace

Status WorldCall::CheckWanted() const {
  if (is_cancelled && is_cancelled()) return absl::CancelledError("the call was cancelled");
  if (is_over && *is_over) return Refuse(Reason::kDraining, "", "the server stops");
  if (std::chrono::steady_clock::now() >= deadline) return absl::DeadlineExceededError("the deadline passed");
  return absl::OkStatus();
}

const WorldMethodInfo& InfoOf(WorldMethod method) {
  static const std::array<WorldMethodInfo, kNames.size()> infos = ReadContract();
  return infos[static_cast<size_t>(method)];
}

Status DecodeRequest(const Bytes& request, google::protobuf::Message* message) {
  const bool fits = request.view.size() <= INT32_MAX;
  if (!fits || !message->ParseFromArray(request.view.data(), static_cast<int>(request.view.size()))) {
    return Refuse(Reason::kInvalidValue, "",
                  "the bytes sent are no " + message->GetTypeName() + ", or a string in them is no UTF-8");
  }
  return ValidateLimits(*message);
}

Bytes EncodeReply(const google::protobuf::Message& message) { return MakeBytes(message.SerializeAsString()); }

Status CheckRequest(WorldMethod method, const Bytes& request) {
  const std::unique_ptr<google::protobuf::Message> message(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(InfoOf(method).request)->New());
  return DecodeRequest(request, message.get());
}

}  // namespace genphys
