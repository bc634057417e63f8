// For builds without a window.
#include "app/trainer/window/mirror.h"

namespace stylet::trainer {

struct Mirror::Impl {
    MirrorChannels channels;
};

Mirror::Mirror(const patient::Patient&, const patient::PlannedPath&, const MirrorSettings&) {
    throw WindowError("this build has no window (STYLET_WINDOW=OFF)");
}
Mirror::~Mirror() = default;
MirrorChannels& Mirror::channels() {
    return impl_->channels;
}
std::uint64_t Mirror::shown() const {
    return 0;
}
std::uint64_t Mirror::validationMessages() const {
    return 0;
}

}  // namespace stylet::trainer
