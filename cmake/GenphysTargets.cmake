# The shapes that our own targets have. Sources are found by pattern, and CONFIGURE_DEPENDS looks again at every build:
# a folder is the unit that people add files to, and a list beside it would only be one more place to forget.

# genphys_sources(<variable> <folder>...): the C++ sources that lie directly in the folders.
function(genphys_sources variable)
  set(found "")
  foreach(folder IN LISTS ARGN)
    file(GLOB in_folder CONFIGURE_DEPENDS "${folder}/*.cc")
    list(APPEND found ${in_folder})
  endforeach()
  set(${variable} "${found}" PARENT_SCOPE)
endfunction()

# genphys_add_library(<name> [PUBLIC <library>...] [PRIVATE <library>...])
# Makes genphys_<name>, also called genphys::<name>, of the folder's include/ and src/, with the folders inside.
function(genphys_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "PUBLIC;PRIVATE")
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/src/*.cc")
  if(NOT sources)
    message(STATUS "genphys_${name}: no sources yet, left out")
    return()
  endif()
  add_library(genphys_${name} STATIC ${sources})
  add_library(genphys::${name} ALIAS genphys_${name})
  target_include_directories(genphys_${name} PUBLIC include PRIVATE src)
  target_link_libraries(genphys_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE} genphys_warnings)
endfunction()

# genphys_add_executable(<name> SOURCES <file>... [LIBRARIES <library>...])
function(genphys_add_executable name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LIBRARIES")
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} genphys_sanitizer genphys_warnings)
endfunction()
