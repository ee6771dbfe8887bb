# genphys_add_test_program(<folder> <library>...)
# Makes <folder>_tests of the sources in the folder and registers it with CTest as several shards. One entry for each
# test would start a process, and under a sanitizer a start of gRPC costs more than most tests.
set(GENPHYS_TEST_SHARDS 2)

function(genphys_add_test_program folder)
  genphys_sources(sources "${CMAKE_CURRENT_SOURCE_DIR}/${folder}")
  if(NOT sources)
    return()
  endif()
  set(program ${folder}_tests)
  add_executable(${program} ${sources})
  target_include_directories(${program} PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
  target_link_libraries(${program} PRIVATE ${ARGN} GTest::gtest GTest::gtest_main GTest::gmock genphys_warnings)

  math(EXPR last "${GENPHYS_TEST_SHARDS} - 1")
  foreach(shard RANGE ${last})
    set(name ${folder}.${shard})
    add_test(NAME ${name}
      COMMAND ${program} --gtest_brief=1 "--gtest_output=xml:${CMAKE_BINARY_DIR}/reports/${name}.xml")
    set_tests_properties(${name} PROPERTIES LABELS ${folder} TIMEOUT 900 ENVIRONMENT
      "GTEST_TOTAL_SHARDS=${GENPHYS_TEST_SHARDS};GTEST_SHARD_INDEX=${shard};${GENPHYS_TEST_ENVIRONMENT}")
  endforeach()
endfunction()

set(GENPHYS_TEST_ENVIRONMENT
  "GENPHYSD=${CMAKE_BINARY_DIR}/bin/genphysd"
  "GENPHYS_SOURCE_DIR=${CMAKE_SOURCE_DIR}")
