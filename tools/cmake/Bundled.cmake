# SPDX-License-Identifier: GPL-3.0-or-later
# The libraries in the folder external/ of a source bundle (tools/packaging/source-bundle): headers, and four small C
# libraries that are compiled here. Their targets have the names that the systems' own packages give them.
set(external ${PROJECT_SOURCE_DIR}/external)
file(STRINGS ${external}/VERSIONS external_versions)
foreach(line ${external_versions})
  message(STATUS "external/: ${line}")
endforeach()

foreach(target Eigen3::Eigen Boost::headers CGAL::CGAL CLI11::CLI11 fmt::fmt nanoflann::nanoflann nlohmann_json::nlohmann_json)
  add_library(${target} INTERFACE IMPORTED)
  target_include_directories(${target} SYSTEM INTERFACE ${external}/include)
endforeach()
target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY)
# As CGAL's own package does, with CGAL's own numbers in place of GMP's: its predicates are exact with either.
find_package(Threads REQUIRED)
target_link_libraries(CGAL::CGAL INTERFACE Threads::Threads)
target_compile_definitions(CGAL::CGAL INTERFACE CGAL_DISABLE_GMP=1)
target_compile_options(CGAL::CGAL INTERFACE $<$<CXX_COMPILER_ID:GNU>:-frounding-math> $<$<CXX_COMPILER_ID:Intel>:-fp-model=strict>)
set(toml11_INCLUDE_DIR ${external}/include)
set(GMP_LIBRARY)
set(MPFR_LIBRARY)

# crackle_external(<target> <folder>): a library of all C files of a folder, of which nothing else sees more than its target
# shows, so that HDF5 goes on with its own zlib.
function(crackle_external target folder)
  file(GLOB sources ${external}/${folder}/*.c)
  list(FILTER sources EXCLUDE REGEX "/(scanner|xmltok_impl|xmltok_ns)[.]c$")  # which others include
  add_library(${target} STATIC ${sources})
  set_target_properties(${target} PROPERTIES C_VISIBILITY_PRESET hidden POSITION_INDEPENDENT_CODE ON UNITY_BUILD OFF)
  target_compile_options(${target} PRIVATE -w)
  target_include_directories(${target} SYSTEM PUBLIC ${external}/${folder})
endfunction()

crackle_external(external_zlib zlib)
target_compile_definitions(external_zlib PUBLIC HAVE_UNISTD_H)
crackle_external(external_png libpng)
target_compile_definitions(external_png PRIVATE PNG_ARM_NEON_OPT=0 PNG_POWERPC_VSX_OPT=0)
target_link_libraries(external_png PUBLIC external_zlib m)
add_library(PNG::PNG ALIAS external_png)

# The settings of these two are given here.
set(external_settings ${PROJECT_BINARY_DIR}/generated/external)
file(WRITE ${external_settings}/config.h "")
file(WRITE ${external_settings}/expat_config.h "")
crackle_external(external_expat expat)
target_include_directories(external_expat PRIVATE ${external_settings})
target_compile_definitions(external_expat PUBLIC XML_STATIC PRIVATE XML_NS XML_DTD XML_CONTEXT_BYTES=1024 XML_DEV_URANDOM
  HAVE_UNISTD_H HAVE_MEMMOVE BYTEORDER=$<IF:$<STREQUAL:${CMAKE_C_BYTE_ORDER},BIG_ENDIAN>,4321,1234>)
# A shared library, as it looks for its units beside itself: ../share/udunits.
file(GLOB udunits_sources ${external}/udunits/*.c)
list(FILTER udunits_sources EXCLUDE REGEX "/scanner[.]c$")
add_library(udunits2 SHARED ${udunits_sources})
set_target_properties(udunits2 PROPERTIES UNITY_BUILD OFF LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib SOVERSION 0)
target_compile_options(udunits2 PRIVATE -w)
target_compile_definitions(udunits2 PRIVATE _GNU_SOURCE DEFAULT_UDUNITS2_XML_PATH="${CMAKE_INSTALL_PREFIX}/share/udunits/udunits2.xml")
target_include_directories(udunits2 SYSTEM PUBLIC ${external}/udunits PRIVATE ${external_settings})
target_link_libraries(udunits2 PRIVATE external_expat m ${CMAKE_DL_LIBS})
add_library(crackle::UDUNITS ALIAS udunits2)
string(REGEX MATCH "udunits ([0-9.]+)" UDUNITS_VERSION "${external_versions}")
set(UDUNITS_VERSION ${CMAKE_MATCH_1})
file(GLOB udunits_units ${external}/udunits/*.xml)
file(COPY ${udunits_units} DESTINATION ${PROJECT_BINARY_DIR}/share/udunits)
install(FILES ${udunits_units} DESTINATION share/udunits)
install(TARGETS udunits2 LIBRARY DESTINATION lib)
install(DIRECTORY ${external}/licences DESTINATION share/crackle)
