// A mock USB bus for programs under umockdev's preload library, with a Falcon that can be plugged in and out.
// It translates the kernel's usbfs requests to the bytes of FalconEmulator.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "tests/support/falcon_emulator.h"

typedef struct _UMockdevTestbed UMockdevTestbed;
typedef struct _UMockdevIoctlBase UMockdevIoctlBase;
typedef struct _UMockdevIoctlClient UMockdevIoctlClient;
typedef struct _UMockdevIoctlData UMockdevIoctlData;

namespace stylet::test {

class FalconTestbed {
  public:
    // True if the preload library is loaded, which this class needs.
    static bool works();

    explicit FalconTestbed(bool has_firmware);
    ~FalconTestbed();
    FalconTestbed(const FalconTestbed&) = delete;
    FalconTestbed& operator=(const FalconTestbed&) = delete;

    void plugIn();
    void plugOut();
    // Calls `call` with the emulator. No request is handled meanwhile.
    template <typename Call>
    auto with(const Call& call) {
        const std::lock_guard lock(mutex_);
        return call(falcon_);
    }

  private:
    struct Urb;
    static int onRequest(UMockdevIoctlBase*, UMockdevIoctlClient*, void* self);
    void handle(UMockdevIoctlClient*);
    void submit(UMockdevIoctlClient*);
    void reap(UMockdevIoctlClient*);
    bool finish(Urb&);

    std::mutex mutex_;
    FalconEmulator falcon_;
    UMockdevTestbed* testbed_;
    UMockdevIoctlBase* handler_;
    std::map<std::uint64_t, std::unique_ptr<Urb>> urbs_;  // by the client's address
    std::uint64_t submitted_ = 0;
    bool plugged_ = false;
    int devices_ = 3;  // number of the newest device; each plugIn() uses the next
};

}  // namespace stylet::test
