# What is installed, where others find it, and the Debian package.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/nanoweft)
set(data_dir ${CMAKE_INSTALL_DATADIR}/nanoweft)

# Libraries outside the system's folders are found by the path with which they were linked.
set_target_properties(nanoweft nanoweft_core PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
if(BUILD_SHARED_LIBS)
  file(RELATIVE_PATH libraries ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(nanoweft PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries}")
endif()

install(TARGETS nanoweft)
install(TARGETS nanoweft_core EXPORT nanoweft FILE_SET HEADERS)
install(EXPORT nanoweft DESTINATION ${package_dir} NAMESPACE nanoweft:: FILE nanoweftTargets.cmake)
write_basic_package_version_file(nanoweftConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES src/cmake/nanoweftConfig.cmake src/cmake/dependencies.cmake
  ${PROJECT_BINARY_DIR}/nanoweftConfigVersion.cmake DESTINATION ${package_dir})

install(FILES src/manual/nanoweft.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(DIRECTORY src/manual/ DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN *.md)
install(FILES LICENSE CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})

# Scenes and commands lie beside each other as in the repository; the commands are called nanoweft-<name>.
foreach(scene fabric composite cantilever spring ladder kink wrap mixed own_geometry periodic settings temperature)
  install(DIRECTORY runs/${scene} DESTINATION ${data_dir}/runs USE_SOURCE_PERMISSIONS
    PATTERN *.png EXCLUDE PATTERN *.jpg EXCLUDE PATTERN __pycache__ EXCLUDE)
endforeach()
install(FILES scripts/environment DESTINATION ${data_dir}/scripts)
install(DIRECTORY scripts/nanoweft DESTINATION ${data_dir}/scripts
  PATTERN __pycache__ EXCLUDE PATTERN scaling EXCLUDE PATTERN speed_error EXCLUDE PATTERN verification EXCLUDE)
file(RELATIVE_PATH commands ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/nanoweft/scripts)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/commands)
foreach(command run report plot render export analyse bundles breaks shares)
  install(PROGRAMS scripts/${command} DESTINATION ${data_dir}/scripts)
  file(CREATE_LINK ${commands}/${command} ${PROJECT_BINARY_DIR}/commands/nanoweft-${command} SYMBOLIC)
  install(FILES ${PROJECT_BINARY_DIR}/commands/nanoweft-${command} DESTINATION ${CMAKE_INSTALL_BINDIR})
endforeach()

# `cpack -G DEB` in the build folder of the preset `package`.
set(CPACK_PACKAGE_CONTACT "the nanoweft authors <nanoweft@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
  "openmpi-bin, python3-numpy, python3-h5py, python3-scipy, python3-matplotlib, python3-pil, libjs-three")
# To link with the library.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
  "cmake, g++, pkg-config, petsc-dev, libopenmpi-dev, libhdf5-openmpi-dev, libmetis-dev, libyaml-dev, libssl-dev")
include(CPack)
