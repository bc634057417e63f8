// Tests XRMOCK_CONTROL through its socket while frames run, and through the Python client.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

using nlohmann::json;

sockaddr_un addressOf(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    return address;
}

// A client of the control channel.
class Wire {
  public:
    explicit Wire(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
        const sockaddr_un address = addressOf(path);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        const timeval patience{60, 0};
        ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    }
    ~Wire() { ::close(socket_); }
    Wire(const Wire&) = delete;
    Wire& operator=(const Wire&) = delete;

    bool send(const std::string& bytes) {
        return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
               static_cast<ssize_t>(bytes.size());
    }
    // Returns null after the runtime has closed the connection.
    json receive() {
        while (in_.find('\n') == std::string::npos) {
            char buffer[1 << 16];
            const ssize_t count = ::recv(socket_, buffer, sizeof buffer, 0);
            if (count <= 0) return nullptr;
            in_.append(buffer, static_cast<std::size_t>(count));
        }
        const std::size_t end = in_.find('\n');
        const json reply = json::parse(in_.substr(0, end));
        in_.erase(0, end + 1);
        return reply;
    }
    json requestReply(const std::string& request) {
        send(request + "\n");
        return receive();
    }

  private:
    int socket_;
    std::string in_;
};

class Control : public MockTest {
  protected:
    void SetUp() override {
        MockTest::SetUp();
        socket_ = file("s").string();
        setVariable("XRMOCK_CONTROL", socket_);
    }
    void TearDown() override {
        stopFrames();
        MockTest::TearDown();
        EXPECT_FALSE(std::filesystem::exists(socket_));
    }
    // A new socket, bound to the control socket's path.
    int boundSocket() {
        const int bound = ::socket(AF_UNIX, SOCK_STREAM, 0);
        const sockaddr_un address = addressOf(socket_);
        EXPECT_EQ(::bind(bound, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        return bound;
    }
    // Simulates an application: runs frames and polls events until stopFrames().
    void startFrames() {
        startFocused();
        application_ = std::thread([this] {
            while (!stop_ && waitFrame() >= 0) {
                if (beginFrame() < 0 || endFrame(1'000'000'000) < 0) break;
                auto event = makeStruct<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
                while (xrPollEvent(instance_, &event) == XR_SUCCESS) {
                    XrEventDataReferenceSpaceChangePending change;
                    std::memcpy(&change, &event, sizeof change);
                    if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING &&
                        change.referenceSpaceType == XR_REFERENCE_SPACE_TYPE_LOCAL) {
                        ++recentred_;
                    }
                    event.type = XR_TYPE_EVENT_DATA_BUFFER;
                }
                std::this_thread::sleep_for(std::chrono::microseconds(200));
            }
        });
    }
    void stopFrames() {
        if (!application_.joinable()) return;
        stop_ = true;
        Wire(socket_).send("{\"pause\": false}\n");
        application_.join();
    }
    int python(const std::string& arguments) {
        const std::string script = std::string(STYLET_SOURCE_DIR) + "/xr/mock/python/xrmock.py";
        return std::system(
            ("python3 " + script + " " + socket_ + " " + arguments + " > " + file("out").string() + " 2>&1")
                .c_str());
    }

    std::string socket_;
    std::atomic<bool> stop_ = false;
    std::atomic<int> recentred_ = 0;
    std::thread application_;
};

TEST_F(Control, ReportsStateAndAppliesFragmentsImmediately) {
    startFrames();
    Wire wire(socket_);
    json reply = wire.requestReply(R"({"id": 7, "get": "state"})");
    EXPECT_EQ(reply["id"], 7);
    EXPECT_EQ(reply["ok"], true);
    EXPECT_EQ(reply["session_state"], "focused");
    EXPECT_GE(reply["frame"], 3);
    EXPECT_NEAR(reply["head"][1].get<double>(), 1.6, 1e-9);
    EXPECT_EQ(reply["statistics"]["refusals"], 0);

    EXPECT_EQ(wire.requestReply(
                  R"({"apply": {"head": [{"position": [1, 2, 3]}], "events": [{"recenter": {}}]}})")["ok"],
              true);
    EXPECT_EQ(wire.requestReply(R"({"wait": {"frame": 20}})")["ok"], true);
    reply = wire.requestReply(R"({"id": "x", "get": "state"})");
    EXPECT_EQ(reply["id"], "x");
    EXPECT_EQ(reply["head"][0], 1.0);
    EXPECT_EQ(reply["local"][2], 3.0);
    stopFrames();
    EXPECT_EQ(recentred_, 1);
}

TEST_F(Control, MovesTheHeadFromWhereItIs) {
    startFrames();
    Wire wire(socket_);
    wire.requestReply(R"({"pause": true})");
    const double t_s = wire.requestReply(R"({"step": 1})")["t_s"];
    wire.requestReply(R"({"apply": {"head": [{"t_s": 1, "position": [9, 1.6, 0]}]}})");
    const json later = wire.requestReply(R"({"step": 45})");
    EXPECT_NEAR(later["t_s"].get<double>(), t_s + 0.5, 1e-6);
    EXPECT_NEAR(later["head"][0].get<double>(), 4.5, 1e-6);
}

TEST_F(Control, FramesWaitForSteps) {
    startFrames();
    Wire wire(socket_);
    wire.requestReply(R"({"pause": true})");
    const std::uint64_t first = wire.requestReply(R"({"step": 1})")["frame"];
    EXPECT_EQ(wire.requestReply(R"({"step": 10})")["frame"], first + 10);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    EXPECT_EQ(wire.requestReply(R"({"get": "state"})")["frame"], first + 10);
    EXPECT_EQ(wire.requestReply(R"({"get": "state"})")["paused"], true);
    wire.requestReply(R"({"pause": false})");
    EXPECT_GE(wire.requestReply("{\"wait\": {\"frame\": " + std::to_string(first + 30) + "}}")["frame"],
              first + 30);
}

TEST_F(Control, ReportsInvalidRequests) {
    startFrames();
    Wire wire(socket_);
    const std::pair<const char*, const char*> cases[] = {
        {R"({"id": 1})", "request: document: one request a line expected"},
        {R"({"gte": "state"})", "request: gte: unknown field"},
        {R"({"get": "stat"})", "request: get: state expected"},
        {R"({"apply": {"version": 2}})", "request: apply.version: unknown field"},
        {R"({"apply": {"head": [{"position": [1, 2]}]}})",
         "request: apply.head[0].position: 3 numbers expected"},
        {R"({"apply": {"events": [{"recenter": {}, "session": "visible"}]}})",
         "request: apply.events[0]: one event at a time expected, not recenter and session"},
        {R"({"apply": {"events": [{"refuse": {"call": "xrFly", "result": "XR_ERROR_RUNTIME_FAILURE"}}]}})",
         "request: apply.events[0].refuse.call: a function that the runtime offers to an instance expected"},
        {R"({"step": 0})", "request: step: a number from 1 to 1e+06 expected"},
        {R"({"wait": {"session_state": "asleep"}})",
         "request: wait.session_state: the name of a session state expected"},
        {R"({"get": "state", "get": "state"})", "request: get: there twice"},
        {"[]", "request: document: an object expected"},
    };
    for (const auto& [request, error] : cases) {
        const json reply = wire.requestReply(request);
        EXPECT_EQ(reply["ok"], false) << request;
        EXPECT_EQ(reply["error"], error) << request;
    }
    EXPECT_EQ(wire.requestReply("{\"id\": \"\xff\"}")["ok"], false);
    EXPECT_EQ(wire.requestReply(R"({"get": "state"})")["ok"], true);
}

TEST_F(Control, HostileClientsDoNotBlockTheApplication) {
    startFrames();
    const std::string flood(4096, '{');
    Wire silent(socket_), endless(socket_), asking(socket_), honest(socket_);
    std::thread attack([&] {
        for (int i = 0; i < 400 && endless.send(flood); ++i) {
        }
        // Sends requests and never reads the replies.
        for (int i = 0; i < 1000; ++i)
            ::usleep(i % 100 == 0 ? 1000 : 0), asking.send("{\"get\": \"state\"}\n");
    });
    for (int i = 0; i < 50; ++i)
        EXPECT_EQ(honest.requestReply(R"({"get": "state"})")["ok"], true);
    attack.join();
    EXPECT_TRUE(endless.receive().is_object());  // the reason for closing the connection
    EXPECT_TRUE(endless.receive().is_null());
    const std::uint64_t frame = honest.requestReply(R"({"get": "state"})")["frame"];
    EXPECT_GT(honest.requestReply("{\"wait\": {\"frame\": " + std::to_string(frame + 20) + "}}")["frame"],
              frame);
}

TEST_F(Control, SendsAPictureOfTheNextFrame) {
    startFrames();
    Wire wire(socket_);
    const json reply = wire.requestReply(R"({"picture": {"eye": "right"}})");
    ASSERT_EQ(reply["ok"], true) << reply;
    EXPECT_TRUE(reply["png"].get<std::string>().starts_with("iVBORw0KGgo"));  // signature of PNG
}

TEST_F(Control, SendsNoPictureOfAnInvisibleFrame) {
    setScript(R"({"version": 2, "events": [{"frame": 1, "frames": {"dropped": true, "count": 1000}}]})");
    startFrames();
    Wire wire(socket_);
    const json reply = wire.requestReply(R"({"picture": {"eye": "left"}})");
    ASSERT_EQ(reply["ok"], true) << reply;
    EXPECT_GT(reply["frame"].get<int>(), 1000);
}

TEST_F(Control, ASocketInUseIsNotReplaced) {
    const int live = boundSocket();
    ASSERT_EQ(::listen(live, 8), 0);
    EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE);
    EXPECT_TRUE(std::filesystem::exists(socket_));
    ::close(live);
    ::unlink(socket_.c_str());
}

TEST_F(Control, ASocketOfAKilledRunIsReplaced) {
    const int dead = boundSocket();
    ::close(dead);
    ASSERT_TRUE(std::filesystem::exists(socket_));
    EXPECT_EQ(tryInstance(), XR_SUCCESS);
}

TEST_F(Control, DisconnectedClientsAreNotWaitedFor) {
    startFrames();
    for (int i = 0; i < 300; ++i)
        Wire(socket_).send("{\"wait\": {\"frame\": 1000000000}}\n");
    Wire wire(socket_);
    const std::uint64_t frame = wire.requestReply(R"({"get": "state"})")["frame"];
    const json reply = wire.requestReply("{\"wait\": {\"frame\": " + std::to_string(frame + 5) + "}}");
    EXPECT_EQ(reply["ok"], true) << reply;
}

TEST_F(Control, APauseMissesNoRefreshes) {
    setVariable("XRMOCK_CLOCK", "real");
    startFrames();
    Wire wire(socket_);
    wire.requestReply(R"({"pause": true})");
    const std::uint64_t missed = wire.requestReply(R"({"step": 1})")["statistics"]["missed"];
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    EXPECT_EQ(wire.requestReply(R"({"step": 1})")["statistics"]["missed"], missed);
}

TEST_F(Control, ThePythonClientWorksAsAModule) {
    startFrames();
    std::ofstream(file("script.py")) << R"(
import sys, xrmock
with xrmock.Client(sys.argv[1], connect_within_s=60, timeout_s=60) as mock:
    try:
        mock.wait(frame=10**9, timeout_s=0.1)
        sys.exit("not reached")
    except TimeoutError:
        pass
    mock.pause()
    mock.step()
    mock.head((1, 1.7, 0))
    mock.controller("left", position=(0, 1, -0.4), select_click=True)
    assert mock.state()["head"][:2] == [1, 1.7]
    try:
        mock.controller("left", menu_clack=True)
        sys.exit("not refused")
    except xrmock.MockError as error:
        assert "menu/clack: unknown component" in str(error), error
    mock.resume()
)";
    const std::string module = std::string(STYLET_SOURCE_DIR) + "/xr/mock/python";
    EXPECT_EQ(std::system(("PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=" + module + " python3 " +
                           file("script.py").string() + " " + socket_)
                              .c_str()),
              0);
}

TEST_F(Control, ThePythonClientSupportsEveryCommand) {
    startFrames();
    EXPECT_EQ(python("state"), 0);
    EXPECT_EQ(python("recenter"), 0);
    EXPECT_EQ(python("pause"), 0);
    EXPECT_EQ(python("step 3"), 0);
    EXPECT_EQ(python("resume"), 0);
    EXPECT_EQ(python("wait '{\"frame\": 10}'"), 0);
    EXPECT_EQ(python("apply '{\"events\": [{\"session\": \"visible\"}]}'"), 0);
    EXPECT_EQ(python("wait '{\"session_state\": \"visible\"}'"), 0);
    EXPECT_EQ(python("picture left " + file("p.png").string()), 0);
    EXPECT_NE(python("apply '{\"x\": 1}'"), 0);
    EXPECT_EQ(python("lose-session --after 0"), 0);
    stop_ = true;
    application_.join();  // its xrWaitFrame returns XR_ERROR_SESSION_LOST
    EXPECT_EQ(waitFrame(), XR_ERROR_SESSION_LOST);
}

}  // namespace
}  // namespace mock_test
