# Language, flags, warnings, sanitizers and the compiler cache, for everything that is compiled here.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type." FORCE)
endif()
# CMake's own -O3 makes the code of gRPC users larger and their build slower for nothing; the core asks for it.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

# A fused multiply-add rounds once where the source says twice, and the compiler is free to fuse or not in each
# function: the same world must have the same bits whatever was inlined where.
add_compile_options(-ffp-contract=off)

# Vectors of three and their matrices start anywhere, and moving their parts in and out of pairs of numbers costs more
# than the pairs save: without it a step takes 0.89 of the instructions in Bullet's pile of 1,000 boxes, 0.97 in 200
# joints, and less time.
add_compile_definitions(EIGEN_UNALIGNED_VECTORIZE=0)

if(GENPHYS_SANITIZER)
  add_compile_options(-fsanitize=${GENPHYS_SANITIZER} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${GENPHYS_SANITIZER})
  if(GENPHYS_SANITIZER MATCHES "undefined")
    # Without it a finding is a line of text in a test that passes.
    add_compile_options(-fno-sanitize-recover=all)
    # A third of the time to compile is for these. The address sanitizer stops at wild and null pointers by itself, and
    # where alignment matters Eigen asserts it.
    if(GENPHYS_SANITIZER MATCHES "address")
      add_compile_options(-fno-sanitize=alignment,null,pointer-overflow)
    endif()
  endif()
endif()

find_program(GENPHYS_CCACHE ccache)
if(GENPHYS_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  # Paths relative to the tree and no working directory in the key: presets and clones share one cache. It asks to be
  # told that a precompiled header is known by its content.
  set(CMAKE_CXX_COMPILER_LAUNCHER env "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros "${PROJECT_SOURCE_DIR}/cmake/ccache_launcher" "${GENPHYS_CCACHE}")
endif()

# genphys_precompile(<target> <header>...): parses what every source of the target reads once instead of once for each.
# A build with GENPHYS_PRECOMPILED_HEADERS=OFF finds the includes that a source lacks.
function(genphys_precompile target)
  if(GENPHYS_PRECOMPILED_HEADERS AND TARGET ${target})
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# gcc 12 believes that members of moved variants are uninitialised; the address sanitizer looks for real ones.
add_library(genphys_warnings INTERFACE)
target_compile_options(genphys_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wno-missing-field-initializers
  -Wno-maybe-uninitialized $<$<BOOL:${GENPHYS_WERROR}>:-Werror>)
