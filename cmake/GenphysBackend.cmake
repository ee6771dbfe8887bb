# genphys_add_backend(NAME <name> RANK <number> [TEST_ONLY] [LIBRARIES <library>...])
#
# Makes the engine adapter of the calling folder part of the build: the library genphys_backend_<name> of include/ and
# src/, the option GENPHYS_BACKEND_<NAME>, and a line in the generated builtin_backends.cc. The adapter gives
# `std::unique_ptr<genphys::Backend> Make<Name>Backend();` in genphys/backends/<name>.h. The lowest RANK is the
# server's default engine. One that is TEST_ONLY is built with the tests and is in no server.
function(genphys_add_backend)
  cmake_parse_arguments(PARSE_ARGV 0 arg "TEST_ONLY" "NAME;RANK" "LIBRARIES")
  if(arg_TEST_ONLY AND NOT GENPHYS_TESTS)
    return()
  endif()
  string(TOUPPER "${arg_NAME}" upper)
  option(GENPHYS_BACKEND_${upper} "Build the ${arg_NAME} engine into the server." ON)
  genphys_sources(sources "${CMAKE_CURRENT_SOURCE_DIR}/src")
  if(NOT GENPHYS_BACKEND_${upper} OR NOT sources)
    return()
  endif()

  set(target genphys_backend_${arg_NAME})
  add_library(${target} STATIC ${sources})
  add_library(genphys::backend_${arg_NAME} ALIAS ${target})
  target_include_directories(${target} PUBLIC include PRIVATE src)
  target_link_libraries(${target} PUBLIC genphys::core PRIVATE ${arg_LIBRARIES} genphys_warnings)
  genphys_precompile(${target} <Eigen/Dense> <genphys/backend.h>)

  get_property(ranked GLOBAL PROPERTY GENPHYS_RANKS)
  if("${ranked}" MATCHES "(^|;)${arg_RANK}:([a-z_]+)")
    message(FATAL_ERROR "engine ${arg_NAME}: RANK ${arg_RANK} is that of ${CMAKE_MATCH_2}; take another one")
  endif()
  set_property(GLOBAL APPEND PROPERTY GENPHYS_RANKS "${arg_RANK}:${arg_NAME}")
  if(arg_TEST_ONLY)
    set_property(GLOBAL APPEND PROPERTY GENPHYS_TEST_BACKENDS "${arg_NAME}")
  else()
    # Natural sorting of rank:name puts the engines in the order of their ranks.
    set_property(GLOBAL APPEND PROPERTY GENPHYS_BACKENDS "${arg_RANK}:${arg_NAME}")
  endif()
endfunction()

# genphys_add_builtin_backends(): the library genphys_backends, which knows every engine that was added before. The list
# is generated text, and not objects that register themselves while they are constructed, because the linker may drop
# such objects and their order is nobody's.
function(genphys_add_builtin_backends)
  get_property(ranked GLOBAL PROPERTY GENPHYS_BACKENDS)
  list(SORT ranked COMPARE NATURAL)
  set(GENPHYS_BACKEND_INCLUDES "")
  set(GENPHYS_BACKEND_ADDITIONS "")
  set(libraries "")
  foreach(entry IN LISTS ranked)
    string(REGEX REPLACE "^[0-9]+:" "" name "${entry}")
    string(REPLACE "_" ";" words "${name}")
    set(camel "")
    foreach(word IN LISTS words)
      string(SUBSTRING "${word}" 0 1 head)
      string(SUBSTRING "${word}" 1 -1 tail)
      string(TOUPPER "${head}" head)
      string(APPEND camel "${head}${tail}")
    endforeach()
    string(APPEND GENPHYS_BACKEND_INCLUDES "#include \"genphys/backends/${name}.h\"\n")
    string(APPEND GENPHYS_BACKEND_ADDITIONS "  registry.Add(Make${camel}Backend());\n")
    list(APPEND libraries genphys::backend_${name})
  endforeach()

  set(generated "${CMAKE_CURRENT_BINARY_DIR}/builtin_backends.cc")
  configure_file("${PROJECT_SOURCE_DIR}/cmake/builtin_backends.cc.in" "${generated}" @ONLY)
  add_library(genphys_backends STATIC "${generated}")
  add_library(genphys::backends ALIAS genphys_backends)
  target_include_directories(genphys_backends PUBLIC "${CMAKE_CURRENT_SOURCE_DIR}/include")
  target_link_libraries(genphys_backends PUBLIC genphys::core PRIVATE ${libraries} genphys_warnings)
endfunction()
