#include "haptics/devices/inverse3/service_linux.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace stylet::haptics {
namespace {

TEST(Service, FindsTcpListenersInTheKernelTable) {
    const char* table =
        "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
        "   0: 0100007F:2711 00000000:0000 0A 00000000:00000000 00:00000000 00000000  1000        0 1 1 0\n"
        "   1: 0100007F:1F90 0100007F:2712 01 00000000:00000000 00:00000000 00000000  1000        0 2 1 0\n";
    EXPECT_TRUE(hasListener(10001, table));
    EXPECT_FALSE(hasListener(8080, table)) << "connected, not listening";
    EXPECT_FALSE(hasListener(10002, table)) << "somebody else's end";
    EXPECT_TRUE(hasListener(10001, "0: 00000000000000000000000001000000:2711 0:0 0A\n"));
    EXPECT_FALSE(hasListener(10001, ""));
    EXPECT_FALSE(hasListener(10001, "0: 2711 0A\n0: x:y z:w 0A\n"));
}

TEST(Service, FindsUnixListenersInTheKernelTable) {
    const char* table =
        "Num       RefCount Protocol Flags    Type St Inode Path\n"
        "0000000000000000: 00000002 00000000 00010000 0001 01 17 /run/user/1/stylet-bridge.sock\n"
        "0000000000000000: 00000003 00000000 00000000 0001 03 18 /run/user/1/connected.sock\n"
        "0000000000000000: 00000002 00000000 00010000 0001 01 19 here.sock\n"
        "0000000000000000: 00000002 00000000 00010000 0001 01 20\n";
    EXPECT_TRUE(hasListener(std::string("/run/user/1/stylet-bridge.sock"), table));
    EXPECT_FALSE(hasListener(std::string("/run/user/2/stylet-bridge.sock"), table));
    EXPECT_FALSE(hasListener(std::string("/run/user/1/connected.sock"), table));
    EXPECT_TRUE(hasListener(std::string("/home/me/here.sock"), table)) << "from its program's folder";
    EXPECT_FALSE(hasListener(std::string("here"), table));
    EXPECT_FALSE(hasListener(std::string(), table));
    EXPECT_FALSE(hasListener(std::string("x"), "x x x\n"));
}

// A socket can have several paths.
TEST(Service, FollowsLinksToTheSocket) {
    const test::TempFolder folder;
    std::filesystem::create_directory(folder / "run");
    std::ofstream(folder / "run" / "a.sock");
    std::ofstream(folder / "run" / "b.sock");
    std::filesystem::create_directory_symlink(folder / "run", folder / "linked");
    std::filesystem::create_symlink(folder / "run" / "a.sock", folder / "link.sock");
    const auto table = [&](const std::filesystem::path& path) {
        return "0000000000000000: 00000002 00000000 00010000 0001 01 17 " + path.string() + "\n";
    };
    const std::string listens = table(folder / "run" / "a.sock");
    EXPECT_TRUE(hasListener((folder / "link.sock").string(), listens));
    EXPECT_TRUE(hasListener((folder / "linked" / "a.sock").string(), listens));
    EXPECT_TRUE(hasListener((folder / "run" / "a.sock").string(), table(folder / "linked" / "a.sock")));
    EXPECT_TRUE(hasListener(std::filesystem::relative(folder / "run" / "a.sock").string(), listens));
    EXPECT_FALSE(hasListener((folder / "linked" / "b.sock").string(), listens));
    std::ofstream(folder / "a.sock");
    EXPECT_FALSE(hasListener((folder / "a.sock").string(), listens)) << "another's of that name";
}

TEST(Service, DetectsAListeningSocket) {
    const int listening = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&address), size), 0);
    ASSERT_EQ(getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size), 0);
    const std::uint16_t port = ntohs(address.sin_port);
    EXPECT_FALSE(hasListener(port));
    ASSERT_EQ(listen(listening, 1), 0);
    EXPECT_TRUE(hasListener(port));
    close(listening);
}

}  // namespace
}  // namespace stylet::haptics
