# Turns a file into a C++ function that is compiled into a program:
#   cmake -DIN=FILE -DNAME=function -DOUT=FILE.cpp -P Embed.cmake
# The function also returns the file's SHA-256, because a page lists the scripts that may run in it by their digests.
file(READ "${IN}" text)
if("${text}" MATCHES "</(script|style)")
    message(FATAL_ERROR "${IN} would end the element that it is put into")
endif()
file(READ "${IN}" hex HEX)
file(SHA256 "${IN}" sha256)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
string(REGEX REPLACE "(................................................................................)" "\\1\n" bytes "${bytes}")
file(WRITE "${OUT}" "#include \"app/report/embedded.h\"

namespace stylet::report {

Embedded ${NAME}() {
    static constexpr unsigned char bytes[] = {
${bytes}};
    return {{reinterpret_cast<const char*>(bytes), sizeof bytes}, \"${sha256}\"};
}

}  // namespace stylet::report
")
