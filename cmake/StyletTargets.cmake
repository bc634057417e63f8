# Flags and helpers that every folder's CMakeLists.txt uses.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

# Asserts stay on in Release: -O2 is where a value-changing transform would first show up.
set(CMAKE_CXX_FLAGS_RELEASE "-O2")
set(CMAKE_C_FLAGS_RELEASE "-O2")
if(STYLET_SANITIZE MATCHES address)
    # A third less time to compile, a seventh more to run; what -O2 does to results the plain builds test.
    set(CMAKE_CXX_FLAGS_RELEASE "-O1")
endif()

find_program(STYLET_CCACHE ccache)
if(STYLET_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${STYLET_CCACHE})
    set(CMAKE_C_COMPILER_LAUNCHER ${STYLET_CCACHE})
endif()

add_library(stylet_flags INTERFACE)
target_compile_options(stylet_flags INTERFACE
    # Bit-equal results across compilers and machines need every product rounded on its own.
    -ffp-contract=off
    -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Werror)
target_include_directories(stylet_flags INTERFACE ${CMAKE_SOURCE_DIR})
# What a program keeps for its next start is another build's no more.
target_link_options(stylet_flags INTERFACE -Wl,--build-id)
if(STYLET_SANITIZE)
    target_compile_options(stylet_flags INTERFACE -fsanitize=${STYLET_SANITIZE} -fno-omit-frame-pointer -g1)
    target_compile_definitions(stylet_flags INTERFACE STYLET_SANITIZED)
    target_link_options(stylet_flags INTERFACE -fsanitize=${STYLET_SANITIZE})
    # Named, as what is found on the way may be another version's, which says so where a test reads.
    find_program(STYLET_SYMBOLIZER_PATH llvm-symbolizer-22)
    set(symbolizer "external_symbolizer_path=$<$<BOOL:${STYLET_SYMBOLIZER_PATH}>:${STYLET_SYMBOLIZER_PATH}>")
    set(STYLET_SANITIZER_ENVIRONMENT "ASAN_OPTIONS=${symbolizer}" "RTSAN_OPTIONS=${symbolizer}"
        "TSAN_OPTIONS=${symbolizer}:suppressions=${CMAKE_SOURCE_DIR}/tests/support/uninstrumented.tsan")
    if(STYLET_SANITIZE MATCHES undefined)
        target_compile_options(stylet_flags INTERFACE -fno-sanitize-recover=undefined)
    endif()
endif()

# The standard headers are two thirds of clang's time. What a file forgets to include, a build without this notices.
option(STYLET_PRECOMPILE "Precompile the standard headers (clang)" OFF)
if(STYLET_PRECOMPILE)
    if(NOT CMAKE_CXX_COMPILER_ID STREQUAL Clang)
        message(FATAL_ERROR "STYLET_PRECOMPILE needs clang: GCC warns of what the precompiled headers hold")
    endif()
    set(CMAKE_CXX_COMPILE_OPTIONS_PIE ${CMAKE_CXX_COMPILE_OPTIONS_PIC})  # programs share what libraries precompile
    set(CMAKE_PCH_INSTANTIATE_TEMPLATES ON)
    target_compile_options(stylet_flags INTERFACE "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-Xclang -fno-pch-timestamp>")  # for ccache
    set(STYLET_STANDARD_HEADERS <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional>
        <map> <memory> <mutex> <optional> <span> <string> <string_view> <thread> <utility> <vector>
        <glm/geometric.hpp> <glm/gtc/quaternion.hpp>)
    add_library(stylet_precompiled STATIC ${CMAKE_SOURCE_DIR}/cmake/empty.cpp)
    target_link_libraries(stylet_precompiled PRIVATE stylet_flags)
    target_precompile_headers(stylet_precompiled PRIVATE ${STYLET_STANDARD_HEADERS})
endif()

# stylet_library(name SOURCES ... PUBLIC ... PRIVATE ... OWN_PRECOMPILED): a static library of one folder.
# OWN_PRECOMPILED: it names the headers that it precompiles itself.
function(stylet_library name)
    cmake_parse_arguments(ARG "OWN_PRECOMPILED" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
    add_library(${name} STATIC ${ARG_SOURCES})
    target_link_libraries(${name} PUBLIC stylet_flags ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
    if(TARGET stylet_precompiled AND NOT ARG_OWN_PRECOMPILED)
        target_precompile_headers(${name} REUSE_FROM stylet_precompiled)
    endif()
endfunction()

# stylet_program(name SOURCES ... LINK ...): a binary in bin/.
function(stylet_program name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE stylet_flags ${ARG_LINK})
endfunction()

# stylet_test(name SOURCES ... LINK ... TIMEOUT seconds LABELS ... PARALLEL ONE_THREAD): a GoogleTest program of tests/<module>.
# One ctest entry a program: most tests are short, and starting a process for each would cost more than running it.
# PARALLEL: it has no clock, device or picture to keep up with, and may run beside others of its kind. Sanitized, all do:
# there none keeps up.
# ONE_THREAD: nothing in it for ThreadSanitizer but loops cut into parts, whose results are compared elsewhere.
function(stylet_test name)
    cmake_parse_arguments(ARG "PARALLEL;ONE_THREAD" "TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
    if(ARG_ONE_THREAD AND STYLET_SANITIZE MATCHES thread)
        return()
    endif()
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE stylet_flags stylet_test_main ${ARG_LINK})
    if(TARGET stylet_precompiled)
        target_precompile_headers(${name} REUSE_FROM stylet_test_main)
    endif()
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    if(NOT ARG_TIMEOUT)
        set(ARG_TIMEOUT 300)
    endif()
    add_test(NAME ${name} COMMAND ${name})
    add_dependencies(test_programs ${name})
    if(NOT ARG_PARALLEL AND NOT STYLET_SANITIZE)
        set_tests_properties(${name} PROPERTIES RUN_SERIAL TRUE)
    endif()
    set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}"
        ENVIRONMENT "STYLET_ASSETS=${CMAKE_SOURCE_DIR}/assets;STYLET_BIN=${CMAKE_RUNTIME_OUTPUT_DIRECTORY};${STYLET_SANITIZER_ENVIRONMENT}")
endfunction()

# stylet_device_test(...): as stylet_test; umockdev stands between the program and sysfs and device nodes. By hand:
# umockdev-wrapper build/release/tests/NAME.
function(stylet_device_test name)
    stylet_test(${name} ${ARGN})
    set(preload libumockdev-preload.so.0)
    # ASan's runtime insists on being loaded first; TSan's would break the shells that the tests start.
    if(STYLET_SANITIZE MATCHES address AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
        execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libasan.so
            OUTPUT_VARIABLE runtime OUTPUT_STRIP_TRAILING_WHITESPACE)
        string(PREPEND preload "${runtime}:")
    endif()
    set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT "LD_PRELOAD=${preload}")
endfunction()
