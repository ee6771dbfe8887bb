#include "genphys/registry.h"

#include <utility>

namespace genphys {

void BackendRegistry::Add(std::unique_ptr<Backend> backend) { backends_.push_back(std::move(backend)); }

const Backend* BackendRegistry::Find(std::string_view name) const {
  for (const std::unique_ptr<Backend>& backend : backends_) {
    if (backend->capabilities().engine() == name) return backend.get();
  }
  return nullptr;
}

Status BackendRegistry::SelfTest() const {
  for (const std::unique_ptr<Backend>& backend : backends_) GENPHYS_RETURN_IF_ERROR(backend->SelfTest());
  return absl::OkStatus();
}

}  // namespace genphys
