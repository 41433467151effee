# ssjs::online, a shared library, and ssjs::online_static, one archive: both libssjs_online, both with one header and no symbol but those of
# the namespace ssjs::online.

file(GLOB ssjs_online_sources CONFIGURE_DEPENDS "cpp/src/embed/*.cpp")
set(ssjs_online_header "${PROJECT_SOURCE_DIR}/cpp/include/ssjs/embed/online.hpp")
set(ssjs_online_parts $<BUILD_INTERFACE:ssjs_slam> $<BUILD_INTERFACE:Threads::Threads>)

add_library(ssjs_online_objects OBJECT ${ssjs_online_sources})
ssjs_compile_options(ssjs_online_objects)
ssjs_count_lines(ssjs_online_objects)
set_target_properties(ssjs_online_objects PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
target_link_libraries(ssjs_online_objects PRIVATE ${ssjs_online_parts})

add_library(ssjs_online SHARED $<TARGET_OBJECTS:ssjs_online_objects>)
set_target_properties(ssjs_online PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
target_link_libraries(ssjs_online PRIVATE ${ssjs_online_parts})
target_link_options(ssjs_online PRIVATE LINKER:--exclude-libs,ALL)
if(SSJS_COVERAGE)
  target_link_options(ssjs_online PRIVATE --coverage)
endif()
if(NOT SSJS_SANITIZE) # whose symbols may come from the program
  target_link_options(ssjs_online PRIVATE LINKER:--no-undefined)
endif()

# The archive holds one object with no global symbol but the interface: another Eigen, with other flags, in the program around it is another
# Eigen. CHOLMOD stays outside.
find_program(SSJS_OBJCOPY NAMES "${CMAKE_OBJCOPY}" objcopy REQUIRED)
set(ssjs_online_whole "${PROJECT_BINARY_DIR}/ssjs_online_whole.o")
add_custom_command(
  OUTPUT "${ssjs_online_whole}"
  COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${ssjs_online_whole}" "-DLINKER=${CMAKE_LINKER}" "-DOBJCOPY=${SSJS_OBJCOPY}" "-DNM=${CMAKE_NM}"
          "-DINPUTS=$<JOIN:$<TARGET_OBJECTS:ssjs_online_objects>,$<COMMA>>,$<TARGET_FILE:ssjs_slam>,$<TARGET_FILE:ssjs_base>"
          "-DKEEP=_ZN4ssjs6online*,_ZNK4ssjs6online*" -P "${PROJECT_SOURCE_DIR}/cmake/merge_objects.cmake"
  DEPENDS $<TARGET_OBJECTS:ssjs_online_objects> ssjs_slam ssjs_base "${PROJECT_SOURCE_DIR}/cmake/merge_objects.cmake"
  VERBATIM)
set_source_files_properties("${ssjs_online_whole}" PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
add_library(ssjs_online_static STATIC "${ssjs_online_whole}")
set_target_properties(ssjs_online_static PROPERTIES OUTPUT_NAME ssjs_online LINKER_LANGUAGE CXX)
target_link_libraries(ssjs_online_static PUBLIC CHOLMOD::CHOLMOD Threads::Threads)

foreach(kind online online_static)
  add_library(ssjs::${kind} ALIAS ssjs_${kind})
  set_target_properties(ssjs_${kind} PROPERTIES EXPORT_NAME ${kind})
  target_sources(ssjs_${kind} PUBLIC FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}/cpp/include" FILES "${ssjs_online_header}")
  target_compile_features(ssjs_${kind} PUBLIC cxx_std_17)
endforeach()
