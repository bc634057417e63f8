// A display made of functions, for tests of the loops.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "app/trainer/view/pictures.h"

namespace stylet::test {

class ScriptedDisplay final : public trainer::Display {
  public:
    using Frame = std::function<bool(const trainer::FrameState&, const std::string& moment)>;
    explicit ScriptedDisplay(Frame frame) : frame_(std::move(frame)) {}

    bool frame(const trainer::FrameState& seen, const patient::ContrastTable*,
               const std::string& moment) override {
        return frame_(seen, moment);
    }
    trainer::PictureTotals totals() const override { return {}; }
    trainer::Attention attention() const override { return watch ? watch() : trainer::Attention::focused; }
    void follow(trainer::LiveUpdates live) override {
        if (followed) followed(std::move(live));
    }

    std::function<trainer::Attention()> watch;           // null: always focused
    std::function<void(trainer::LiveUpdates)> followed;  // null: ignored

  private:
    Frame frame_;
};

}  // namespace stylet::test
