// Runs `stylet doctor` as a user does: with the mock runtime and with faulty runtimes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>

#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Doctor : public testing::Test {
  protected:
    Doctor() {
        command_.set("XDG_CONFIG_HOME", (command_ / "config").string());
        command_.set("XDG_CONFIG_DIRS", (command_ / "etc").string());
        command_.set("XDG_DATA_HOME", (command_ / "data").string());
    }
    void useRuntime(const std::string& manifest) { command_.set("XR_RUNTIME_JSON", manifest); }
    void useMock(const json& scenario = {{"version", 2}}) {
        useRuntime(STYLET_MOCK_MANIFEST);
        write("scenario.json", scenario.dump());
        command_.set("XRMOCK_SCENARIO", (command_ / "scenario.json").string());
    }
    void useBadRuntime(const char* fault) {
        write("bad.json", json{{"file_format_version", "1.0.0"},
                               {"runtime", {{"name", "bad"}, {"library_path", STYLET_BAD_RUNTIME}}}}
                              .dump());
        useRuntime((command_ / "bad.json").string());
        command_.set("STYLET_BAD_RUNTIME", fault);
        command_.set("STYLET_GOOD_RUNTIME",
                     (std::filesystem::path(STYLET_MOCK_MANIFEST).parent_path() / "libxrmock.so").string());
    }
    void write(const std::string& name, const std::string& text) { std::ofstream(command_ / name) << text; }
    // Runs the command. Sets the status and the findings.
    void examine(const std::string& arguments = "", const std::string& before = "") {
        const test::Outcome outcome = command_.runBare("doctor --json " + patience_ + arguments, before);
        status_ = outcome.status;
        err_ = outcome.err;
        const json read = json::parse(outcome.out, nullptr, false);
        ASSERT_TRUE(read.is_object()) << outcome.out << outcome.err;
        findings_ = read.at("findings");
        bool problem = false;
        for (const json& finding : findings_) {
            problem = problem || finding.at("state") == "problem";
            // Every finding that is not ok tells the user what to do.
            EXPECT_TRUE(finding.at("state") == "ok" || finding.at("todo") != "") << finding;
            EXPECT_NE(finding.at("found"), "") << finding;
        }
        EXPECT_EQ(status_, problem ? 1 : 0);
    }
    // Returns the first finding about `what`.
    json about(const std::string& what) const {
        for (const json& finding : findings_)
            if (finding.at("what") == what) return finding;
        return {{"state", "absent"}, {"found", ""}, {"todo", ""}};
    }
    void expectAbout(const std::string& what, const std::string& state, const std::string& found) const {
        const json finding = about(what);
        EXPECT_EQ(finding.at("state"), state) << what << ": " << finding;
        EXPECT_THAT(finding.at("found").get<std::string>(), HasSubstr(found)) << finding;
    }

    test::Command command_;
    std::string patience_ = "--patience 60 ";  // long, because the machine may be busy
    int status_ = -1;
    std::string err_;
    json findings_;
};

TEST_F(Doctor, MissingRuntimeListsTheSearchedPlaces) {
    examine();
    EXPECT_EQ(status_, 1);
    expectAbout("runtime", "problem", (command_ / "config").string() + "/openxr/1/active_runtime.json");
    expectAbout("runtime", "problem", (command_ / "etc").string());
    EXPECT_THAT(about("runtime").at("todo").get<std::string>(), HasSubstr("XR_RUNTIME_JSON"));
    for (const char* what : {"udev rules", "real-time priority", "locked memory", "assets", "cache", "data",
                             "registration", "window"})
        EXPECT_NE(about(what).at("state"), "absent") << what;
    EXPECT_EQ(err_, "");
}

TEST_F(Doctor, ABrokenManifestIsNamed) {
    for (const char* text : {"", "{", "[]", "{\"runtime\": 3}", "{\"runtime\": {\"library_path\": 5}}"}) {
        write("broken.json", text);
        useRuntime((command_ / "broken.json").string());
        examine();
        EXPECT_EQ(status_, 1);
        expectAbout("runtime", "problem", "broken.json");
        expectAbout("runtime", "problem", "library_path");
    }
}

TEST_F(Doctor, AMissingLibraryIsNamed) {
    write("gone.json", R"({"runtime": {"library_path": "./libgone.so"}})");
    useRuntime((command_ / "gone.json").string());
    examine();
    EXPECT_EQ(status_, 1);
    expectAbout("runtime", "problem", "libgone.so");
}

TEST_F(Doctor, AWholeRuntimeIsDescribed) {
    useMock();
    examine();
    expectAbout("runtime", "ok", "xrmock.json");
    expectAbout("runtime answers", "ok", "XR Mock");
    expectAbout("headset", "ok", "XR Mock HMD");
    expectAbout("extensions", "ok", "XR_KHR_vulkan_enable2");
    expectAbout("session", "ok", "focus");
    expectAbout("display", "ok", "90 Hz");
    expectAbout("display", "ok", "640 x 640");
    expectAbout("space", "ok", "stage");
    expectAbout("controllers", "ok", "/interaction_profiles/khr/simple_controller");
    EXPECT_NE(about("graphics of the headset").at("state"), "problem");
    EXPECT_NE(about("graphics").at("state"), "absent");
}

TEST_F(Doctor, WithoutControllersOrFocusItWarns) {
    patience_ = "--patience 12 ";  // much of this time is spent waiting for the focus
    useMock({{"version", 2},
             {"controllers", json::object()},
             {"session", {{{"t_s", 0}, {"state", "visible"}}}},
             {"refresh_hz", 72}});
    examine();
    expectAbout("session", "warning", "another program has the focus");
    expectAbout("controllers", "warning", "nothing");
    expectAbout("display", "warning", "72 Hz");
}

TEST_F(Doctor, NoHeadsetIsAProblem) {
    useBadRuntime("xrGetSystem");
    examine();
    EXPECT_EQ(status_, 1);
    expectAbout("headset", "problem", "has no headset");
}

TEST_F(Doctor, ARuntimeThatRefusesASessionIsAProblem) {
    useBadRuntime("xrCreateSession");
    examine();
    EXPECT_EQ(status_, 1);
    expectAbout("headset", "ok", "XR Mock HMD");
    expectAbout("headset refuses", "problem", "xrCreateSession");
}

TEST_F(Doctor, HangingRuntimeTimesOut) {
    useBadRuntime("hang");
    patience_.clear();
    const auto began = std::chrono::steady_clock::now();
    examine();
    const auto took = std::chrono::steady_clock::now() - began;
    RecordProperty("took_ms", int(took / std::chrono::milliseconds(1)));
    EXPECT_EQ(status_, 1);
    expectAbout("runtime hangs", "problem", "within 5 s");
    expectAbout("runtime hangs", "problem", "loading it");
    EXPECT_NE(about("cache").at("state"), "absent");  // the other checks still run
}

TEST_F(Doctor, RuntimeCrashIsReported) {
    useBadRuntime("crash");
    examine();
    EXPECT_EQ(status_, 1);
    expectAbout("runtime crashes", "problem", "ended the program");
    expectAbout("runtime crashes", "problem", "loading it");
}

TEST_F(Doctor, FoldersThatCannotBeWrittenAreAProblem) {
    command_.set("XDG_DATA_HOME", "/proc/none");
    examine();
    EXPECT_EQ(status_, 1);
    expectAbout("data", "problem", "/proc/none/stylet");
    expectAbout("cache", "ok", "GB free");
}

TEST_F(Doctor, AFolderThatLacksAssetsIsAProblem) {
    command_.set("STYLET_ASSETS", "/nonexistent");
    examine();
    EXPECT_EQ(status_, 1);
    expectAbout("assets", "problem", "STYLET_ASSETS: /nonexistent: ");
    write("difficulty.toml", "");
    std::filesystem::create_directory(command_ / "looks");
    command_.set("STYLET_ASSETS", (command_ / "").string());
    examine();
    expectAbout("assets", "problem", "missing: cases, instruments, rooms, scenarios, tissue/ptcd.toml");
}

// Services and containers may have no home folder.
TEST_F(Doctor, ADataFolderThatIsTemporaryIsAWarning) {
    command_.set("XDG_DATA_HOME", "");
    command_.set("HOME", "");
    command_.set("TMPDIR", (command_ / "").string());
    examine();
    expectAbout("data", "warning", (command_ / "stylet").string() + ", ");
    expectAbout("data", "warning", "temporary: attempts stored there will be lost");
    EXPECT_THAT(about("data").at("todo").get<std::string>(), HasSubstr("set XDG_DATA_HOME"));
    command_.set("HOME", (command_ / "home").string());
    examine();
    expectAbout("data", "ok", (command_ / "home/.local/share/stylet").string());
}

TEST_F(Doctor, RecordsAndRegistrationsAreRead) {
    std::filesystem::create_directories(command_ / "kept" / "one" / "record");
    std::filesystem::create_directories(command_ / "data" / "stylet" / "registrations");
    write("kept/one/record/record.json", "{}");
    write("data/stylet/registrations/falcon.json", "{}");
    examine("--records '" + (command_ / "kept").string() + "'");
    EXPECT_EQ(status_, 1);
    expectAbout("records", "problem", "record");
    expectAbout("registration", "problem", "falcon.json");
    examine("--records '" + (command_ / "nowhere").string() + "'");
    expectAbout("records", "problem", "not a folder");
}

// Runs as a user without privileges, because limits do not apply to root.
TEST_F(Doctor, RefusedRealTimeIsAWarningWithTheLineThatAllowsIt) {
    const std::string as_nobody =
        geteuid() == 0 ? "prlimit --rtprio=0:0 --memlock=0:0 setpriv --reuid=65534 --regid=65534 "
                         "--clear-groups env "
                       : "prlimit --rtprio=0:0 --memlock=0:0 env ";
    const std::string reach = as_nobody + "test -x '" + std::getenv("STYLET_BIN") + "/stylet' 2>/dev/null";
    if (std::system(reach.c_str()) != 0)
        GTEST_SKIP() << "no prlimit or setpriv, or the build folder is closed to other users";
    examine("", as_nobody);
    expectAbout("real-time priority", "warning", "refused");
    expectAbout("locked memory", "warning", "refused");
    const bool installed = std::filesystem::exists("/etc/security/limits.d/stylet.conf");
    EXPECT_THAT(about("locked memory").at("todo").get<std::string>(),
                HasSubstr(installed ? "sudo adduser" : "memlock unlimited"));
}

TEST(DoctorForPeople, IsReadableAndSaysWhatToDo) {
    test::Command command;
    command.set("XDG_CONFIG_HOME", (command / "config").string());
    const test::Outcome outcome = command.runBare("doctor");
    EXPECT_THAT(outcome.out, HasSubstr("problem  runtime"));
    EXPECT_THAT(outcome.out, HasSubstr("-> "));
    EXPECT_EQ(outcome.status, 1);
}

}  // namespace
}  // namespace stylet::trainer
