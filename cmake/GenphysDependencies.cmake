# Every library from outside, found once. docs/decisions/ says why each was taken.

set(THREADS_PREFER_PTHREAD_FLAG ON)
# A program that has this tree as a folder links what our libraries link.
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)

# The module comes first: Debian 12 ships no protobuf-config.cmake, and gRPC's own configuration expects its targets.
find_package(Protobuf REQUIRED)
find_package(gRPC CONFIG REQUIRED)  # and re2::re2
find_package(absl CONFIG REQUIRED)
find_package(Eigen3 3.4 CONFIG REQUIRED)
find_package(spdlog CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET GLOBAL libxxhash)
pkg_check_modules(qhull REQUIRED IMPORTED_TARGET GLOBAL qhull_r)
if(NOT GENPHYS_SANITIZER)
  # Sanitizers bring an allocator of their own.
  pkg_check_modules(tcmalloc REQUIRED IMPORTED_TARGET GLOBAL libtcmalloc_minimal)
endif()

# Users of a clone and the tests run Debian's interpreter, for it is the one that Debian's grpc module is installed for.
set(GENPHYS_PYTHON "/usr/bin/python3" CACHE FILEPATH "The Python interpreter that runs checks and Python tests.")

if(GENPHYS_TESTS)
  find_package(GTest REQUIRED)
endif()
if(GENPHYS_BENCH)
  find_package(benchmark CONFIG REQUIRED)
endif()

# What every program is linked with besides its own libraries.
if(GENPHYS_SANITIZER STREQUAL "thread")
  add_library(genphys_sanitizer OBJECT "${PROJECT_SOURCE_DIR}/cmake/sanitizers/thread_grpc.cc")
  target_link_libraries(genphys_sanitizer PUBLIC gRPC::grpc++ absl::synchronization)
else()
  add_library(genphys_sanitizer INTERFACE)
endif()
