#pragma once
#include "genphys/client/options.h"
#include "genphys/client/world.h"
#include "genphys/v1/frame.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "keyframes.h"

// Between the client's own values and messages; those of the model are wire's.

namespace genphys::client {

void EncodeFrameOptions(const FrameOptions& options, v1::FrameRequest* out);
void EncodeEventOptions(const EventOptions& options, v1::EventFilter* out);
void EncodeStep(uint32_t steps, const StepOptions& options, v1::StepRequest* out);

/// Every event of a batch. INTERNAL for one that this build cannot read.
Result<std::vector<Event>> DecodeEvents(const v1::EventBatch& batch);

/// What came of a step, whose frame may be a delta against `keyframe`. The frame keeps `response` alive.
Result<StepResult> DecodeStep(std::shared_ptr<const v1::StepResponse> response, const FramePtr& keyframe = nullptr);

}  // namespace genphys::client
