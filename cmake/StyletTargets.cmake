# Flags and helpers that every folder's CMakeLists.txt uses.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

# Asserts stay on in Release (no NDEBUG), so that errors that appear only at -O2 are found.
set(CMAKE_CXX_FLAGS_RELEASE "-O2")
set(CMAKE_C_FLAGS_RELEASE "-O2")
if(STYLET_SANITIZE MATCHES address)
    # -O1 compiles a third faster than -O2 and runs a seventh slower. Builds without sanitizers test the effects of -O2.
    set(CMAKE_CXX_FLAGS_RELEASE "-O1")
endif()

# Debian's /usr/lib/ccache holds links to ccache that are named like compilers. If PATH begins with it, CMake uses such a
# link, and needs no launcher: ccache would start ccache, would not know which compiler it is, and would compile
# precompiled headers, and all that include them, in every build folder again.
find_program(STYLET_CCACHE ccache)
file(REAL_PATH "${CMAKE_CXX_COMPILER}" real_compiler)
if(STYLET_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER AND NOT real_compiler MATCHES "/ccache$")
    set(CMAKE_CXX_COMPILER_LAUNCHER ${STYLET_CCACHE})
    set(CMAKE_C_COMPILER_LAUNCHER ${STYLET_CCACHE})
endif()

# Optimization level of code that runs only once, such as tests and the parsing of command lines.
set(STYLET_FAST_COMPILE "$<$<CONFIG:Release>:-O1>")

add_library(stylet_flags INTERFACE)
target_compile_options(stylet_flags INTERFACE
    # No fused multiply-add: bit-equal results across compilers and machines need every product rounded separately.
    -ffp-contract=off
    -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Werror)
target_include_directories(stylet_flags INTERFACE ${CMAKE_SOURCE_DIR})
# The build ID is part of the key of cached files, so that no other build uses them.
target_link_options(stylet_flags INTERFACE -Wl,--build-id)
if(STYLET_SANITIZE)
    target_compile_options(stylet_flags INTERFACE -fsanitize=${STYLET_SANITIZE} -fno-omit-frame-pointer -g1)
    target_compile_definitions(stylet_flags INTERFACE STYLET_SANITIZED)
    target_link_options(stylet_flags INTERFACE -fsanitize=${STYLET_SANITIZE})
    # Set explicitly, because another version found in PATH would print warnings into output that tests read.
    find_program(STYLET_SYMBOLIZER_PATH llvm-symbolizer-22)
    set(symbolizer "external_symbolizer_path=$<$<BOOL:${STYLET_SYMBOLIZER_PATH}>:${STYLET_SYMBOLIZER_PATH}>")
    set(STYLET_SANITIZER_ENVIRONMENT "ASAN_OPTIONS=${symbolizer}" "RTSAN_OPTIONS=${symbolizer}"
        "TSAN_OPTIONS=${symbolizer}:suppressions=${CMAKE_SOURCE_DIR}/tests/support/uninstrumented.tsan")
    if(STYLET_SANITIZE MATCHES undefined)
        target_compile_options(stylet_flags INTERFACE -fno-sanitize-recover=undefined)
    endif()
endif()

# Reading and instantiating headers costs about half of a source's compile time. Two options reduce it:
# - STYLET_UNITY compiles the sources of a target twenty at a time. Names at file scope must be unique per target.
# - STYLET_PRECOMPILE precompiles the standard headers, for the program and, with GoogleTest, for the tests.
# Both hide a missing #include. `packaging/test --all` also builds without them.
option(STYLET_UNITY "Compile the sources of a target twenty at a time" ON)
option(STYLET_PRECOMPILE "Precompile the standard headers" ON)
if(STYLET_UNITY)
    set(CMAKE_UNITY_BUILD ON)
    set(CMAKE_UNITY_BUILD_BATCH_SIZE 20)
    # GCC warns about a public type that has a member of a file-local type unless that file is the main source. GCC 12
    # reports false overflows in copies of std::string when it inlines more.
    target_compile_options(stylet_flags INTERFACE
        "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-restrict>")
endif()
if(STYLET_PRECOMPILE)
    set(CMAKE_CXX_COMPILE_OPTIONS_PIE ${CMAKE_CXX_COMPILE_OPTIONS_PIC})  # programs reuse the libraries' precompiled headers
    if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
        set(CMAKE_PCH_INSTANTIATE_TEMPLATES ON)
        target_compile_options(stylet_flags INTERFACE "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-Xclang -fno-pch-timestamp>")  # for ccache
    endif()
    set(STYLET_STANDARD_HEADERS <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional>
        <map> <memory> <mutex> <optional> <span> <string> <string_view> <thread> <utility> <vector>
        <fmt/core.h> <glm/geometric.hpp> <glm/gtc/quaternion.hpp>)
endif()

# stylet_library(name SOURCES ... PUBLIC ... PRIVATE ... OWN_PRECOMPILED NUMERIC): a static library of one folder.
# OWN_PRECOMPILED: the library sets its own precompiled headers.
# NUMERIC: it computes on volumes and has no threads or callbacks that outlive a call. AddressSanitizer does not look
# for uses of returned stack frames there, which takes 40 % of the time of such code.
function(stylet_library name)
    cmake_parse_arguments(ARG "OWN_PRECOMPILED;NUMERIC" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
    add_library(${name} STATIC ${ARG_SOURCES})
    if(ARG_NUMERIC AND STYLET_SANITIZE MATCHES address AND CMAKE_CXX_COMPILER_ID STREQUAL Clang)
        target_compile_options(${name} PRIVATE -fsanitize-address-use-after-return=never)
    endif()
    target_link_libraries(${name} PUBLIC stylet_flags ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
    if(TARGET stylet_precompiled AND NOT ARG_OWN_PRECOMPILED)
        target_precompile_headers(${name} REUSE_FROM stylet_precompiled)
    endif()
endfunction()

# stylet_vectorised(SOURCE...): GCC vectorises loops over rows of voxels only at -O3; a line filter then takes a fifth of
# the time. A unity build or a precompiled header would bring its own level.
function(stylet_vectorised)
    set_source_files_properties(${ARGN} PROPERTIES
        COMPILE_OPTIONS $<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU>>:-O3>
        SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# stylet_program(name SOURCES ... LINK ...): a binary in bin/. main.cpp only connects modules, so it is optimised for
# compile time.
function(stylet_program name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE stylet_flags ${ARG_LINK})
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # clang rejects headers precompiled at another optimization level
        list(FILTER ARG_SOURCES INCLUDE REGEX "(^|/)main\\.cpp$")
        set_source_files_properties(${ARG_SOURCES} PROPERTIES COMPILE_OPTIONS ${STYLET_FAST_COMPILE})
    endif()
    if(TARGET stylet_precompiled)
        target_precompile_headers(${name} REUSE_FROM stylet_precompiled)
    endif()
endfunction()

# stylet_test(name SOURCES ... LINK ... TIMEOUT seconds LABELS ... REAL_TIME ALL_REAL_TIME ONE_THREAD
# ONE_THREAD_TESTS ... REPEATED_TESTS ...): a GoogleTest program of tests/<module>.
# One ctest entry per program: most tests are short, and a process for each would take longer than the test itself.
# Programs with the longest timeout start first, so that none runs alone at the end.
# REAL_TIME: some of its suites are named *RealTime. They need the wall clock, so they have a separate entry
# NAME_real_time, which `packaging/test --stutter` repeats. ALL_REAL_TIME: all its suites need it.
# ONE_THREAD: left out under ThreadSanitizer. Its only threads are parallel loops, whose results other tests compare.
# ONE_THREAD_TESTS: patterns of tests to which the same applies, in a program that has other tests too.
# REPEATED_TESTS: patterns of tests that every sanitizer leaves out. They run code of the program's other tests again,
# with other numbers: for statistics, or with other mistakes of a simulated trainee.
function(stylet_test name)
    cmake_parse_arguments(ARG "REAL_TIME;ALL_REAL_TIME;ONE_THREAD" "TIMEOUT" "SOURCES;LINK;LABELS;ONE_THREAD_TESTS;REPEATED_TESTS" ${ARGN})
    if(ARG_ONE_THREAD AND STYLET_SANITIZE MATCHES thread)
        return()
    endif()
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE stylet_flags stylet_test_main ${ARG_LINK})
    target_compile_options(${name} PRIVATE ${STYLET_FAST_COMPILE})
    if(TARGET stylet_precompiled)
        if(TARGET stylet_test_json AND "nlohmann_json::nlohmann_json" IN_LIST ARG_LINK)
            target_precompile_headers(${name} REUSE_FROM stylet_test_json)
        else()
            target_precompile_headers(${name} REUSE_FROM stylet_test_main)
        endif()
    endif()
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    add_dependencies(test_programs ${name})
    if(NOT ARG_TIMEOUT)
        set(ARG_TIMEOUT 300)
    endif()
    set(left_out "")  # of the entry NAME
    if(ARG_REAL_TIME)
        list(APPEND left_out "*RealTime.*")
    endif()
    if(STYLET_SANITIZE MATCHES thread)
        list(APPEND left_out ${ARG_ONE_THREAD_TESTS})
    endif()
    if(STYLET_SANITIZE)
        list(APPEND left_out ${ARG_REPEATED_TESTS})
    endif()
    set(filter "")
    if(left_out)
        list(JOIN left_out ":" left_out)
        set(filter "--gtest_filter=-${left_out}")
    endif()
    add_test(NAME ${name} COMMAND ${name} ${filter})
    set(entries ${name})
    set(real_time "")
    if(ARG_ALL_REAL_TIME)
        set(real_time ${name})
    elseif(ARG_REAL_TIME)
        add_test(NAME ${name}_real_time COMMAND ${name} --gtest_filter=*RealTime.*)
        if(NOT STYLET_SANITIZE)  # fail if no suite matches, for example after a rename
            set_tests_properties(${name}_real_time PROPERTIES FAIL_REGULAR_EXPRESSION "Running 0 tests")
        endif()
        set(real_time ${name}_real_time)
        list(APPEND entries ${real_time})
    endif()
    set_tests_properties(${entries} PROPERTIES TIMEOUT ${ARG_TIMEOUT} COST ${ARG_TIMEOUT} LABELS "${ARG_LABELS}"
        ENVIRONMENT "STYLET_ASSETS=${CMAKE_SOURCE_DIR}/assets;STYLET_BIN=${CMAKE_RUNTIME_OUTPUT_DIRECTORY};${STYLET_SANITIZER_ENVIRONMENT}")
    if(real_time)
        set_property(TEST ${real_time} APPEND PROPERTY LABELS real_time)
        # Only one real-time test runs at a time. Other tests may run beside it: a busy machine does not make it fail.
        set_tests_properties(${real_time} PROPERTIES RESOURCE_LOCK real_time)
    endif()
    set(STYLET_TEST_ENTRIES ${entries} PARENT_SCOPE)
endfunction()

# stylet_device_test(...): as stylet_test, but umockdev intercepts access to sysfs and device nodes. To run such a test
# by hand: umockdev-wrapper build/release/tests/NAME.
function(stylet_device_test name)
    stylet_test(${name} ${ARGN})
    set(preload libumockdev-preload.so.0)
    # ASan's runtime must be loaded first. TSan's is not preloaded, because it breaks the shells that the tests start.
    if(STYLET_SANITIZE MATCHES address AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
        execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libasan.so
            OUTPUT_VARIABLE runtime OUTPUT_STRIP_TRAILING_WHITESPACE)
        string(PREPEND preload "${runtime}:")
    endif()
    set_property(TEST ${STYLET_TEST_ENTRIES} APPEND PROPERTY ENVIRONMENT "LD_PRELOAD=${preload}")
endfunction()
