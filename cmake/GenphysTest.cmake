# How tests and checks are registered with CTest. Labels are folders, and script/test selects by them.
set(GENPHYS_TEST_SHARDS 2)
set(GENPHYS_TEST_ENVIRONMENT
  "GENPHYS_SERVER=${CMAKE_BINARY_DIR}/bin/genphysd"
  "GENPHYS_BUF=${CMAKE_SOURCE_DIR}/build/tools/bin/buf"
  "GENPHYS_GRPCURL=${CMAKE_SOURCE_DIR}/build/tools/bin/grpcurl"
  "GENPHYS_BUILD_DIR=${CMAKE_BINARY_DIR}"
  "PYTHONPATH=${CMAKE_SOURCE_DIR}/client/python"
  "PYTHONDONTWRITEBYTECODE=1"
  "ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1"
  "UBSAN_OPTIONS=print_stacktrace=1")

# genphys_add_test_program(<folder> [LONG] <library>...)
# Makes <folder>_tests of the sources in the folder and registers it as several shards. One entry for each test would
# start a process, and under a sanitizer a start of gRPC costs more than most tests. LONG ones run only when asked for.
function(genphys_add_test_program folder)
  cmake_parse_arguments(PARSE_ARGV 1 arg "LONG" "" "")
  genphys_sources(sources "${CMAKE_CURRENT_SOURCE_DIR}/${folder}")
  if(NOT sources)
    return()
  endif()
  set(program ${folder}_tests)
  add_executable(${program} ${sources})
  # The root too: unit tests reach the private headers of what they test.
  target_include_directories(${program} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}")
  target_link_libraries(${program} PRIVATE ${arg_UNPARSED_ARGUMENTS} GTest::gtest GTest::gtest_main GTest::gmock
    genphys_sanitizer genphys_warnings)
  # All of them read the same libraries.
  if(GENPHYS_PRECOMPILED_HEADERS AND TARGET genphys_test_support)
    target_precompile_headers(${program} REUSE_FROM genphys_test_support)
  endif()
  if(TARGET genphysd)
    # Tests start the server themselves; building one program must give them the server of the same sources.
    add_dependencies(${program} genphysd)
  endif()

  math(EXPR last "${GENPHYS_TEST_SHARDS} - 1")
  foreach(shard RANGE ${last})
    set(name ${folder}.${shard})
    add_test(NAME ${name}
      COMMAND ${program} --gtest_brief=1 "--gtest_output=xml:${CMAKE_BINARY_DIR}/reports/${name}.xml")
    set_tests_properties(${name} PROPERTIES LABELS "${folder};$<$<BOOL:${arg_LONG}>:long>" TIMEOUT $<IF:$<BOOL:${arg_LONG}>,7200,900> ENVIRONMENT
      "GTEST_TOTAL_SHARDS=${GENPHYS_TEST_SHARDS};GTEST_SHARD_INDEX=${shard};${GENPHYS_TEST_ENVIRONMENT}")
  endforeach()
endfunction()

# genphys_add_check(<name> <command>...): a command, run in the source tree, whose exit status is the verdict.
function(genphys_add_check name)
  add_test(NAME ${name} COMMAND ${ARGN} WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}")
  set_tests_properties(${name} PROPERTIES LABELS check TIMEOUT 300 ENVIRONMENT "${GENPHYS_TEST_ENVIRONMENT}")
endfunction()

# genphys_add_pytest(<name> <folder>): the Python tests of a folder of the source tree, once it has some.
function(genphys_add_pytest name folder)
  file(GLOB_RECURSE tests CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/${folder}/test_*.py" "${CMAKE_SOURCE_DIR}/${folder}/*_test.py")
  if(NOT tests)
    return()
  endif()
  genphys_add_check(${name} "${GENPHYS_PYTHON}" -m pytest -q -p no:cacheprovider ${folder}
    "--junitxml=${CMAKE_BINARY_DIR}/reports/${name}.xml")
  set_tests_properties(${name} PROPERTIES LABELS python TIMEOUT 900)
endfunction()
