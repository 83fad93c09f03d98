# The program for several instruction sets, and bin/nanoweft, which starts the best that a processor has. A variant
# is compiled as a whole: so no inlined function of one gets into another.
include(GNUInstallDirs)

if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  message(FATAL_ERROR "NANOWEFT_VARIANTS: there are several instruction sets for x86-64 alone")
endif()

set(variants_dir ${CMAKE_INSTALL_LIBEXECDIR}/nanoweft)
foreach(arch x86-64 x86-64-v3 x86-64-v4)
  set(program nanoweft-${arch})
  add_executable(${program} src/main.cpp)
  if(arch STREQUAL NANOWEFT_ARCH)
    target_link_libraries(${program} PRIVATE nanoweft_core nanoweft_internals)
  else()
    add_library(nanoweft_core_${arch} STATIC ${NANOWEFT_SOURCES})
    target_link_libraries(nanoweft_core_${arch} PUBLIC nanoweft_any_arch)
    target_compile_options(nanoweft_core_${arch} PUBLIC -march=${arch})
    target_link_libraries(${program} PRIVATE nanoweft_core_${arch})
  endif()
  set_target_properties(${program} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${variants_dir} INSTALL_RPATH_USE_LINK_PATH ON)
  install(TARGETS ${program} DESTINATION ${variants_dir})
endforeach()

add_executable(nanoweft src/launcher.cpp)
file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBEXECDIR}/nanoweft)
target_compile_definitions(nanoweft PRIVATE NANOWEFT_VARIANTS_DIR="${from_bin}")
target_compile_options(nanoweft PRIVATE -Wall -Wextra -Wpedantic -march=x86-64)
