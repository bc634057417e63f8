// A display made of functions, for tests of the loops.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "app/trainer/view/pictures.h"

namespace stylet::test {

class ScriptedDisplay final : public trainer::Display {
  public:
    using Frame = std::function<bool(const trainer::Seen&, const std::string& moment)>;
    explicit ScriptedDisplay(Frame frame) : frame_(std::move(frame)) {}

    bool frame(const trainer::Seen& seen, const patient::ContrastTable*, const std::string& moment) override {
        return frame_(seen, moment);
    }
    trainer::PictureTotals totals() const override { return {}; }
    trainer::Attention attention() const override { return watch ? watch() : trainer::Attention::focused; }
    void follow(trainer::LiveSeen live) override {
        if (followed) followed(std::move(live));
    }

    std::function<trainer::Attention()> watch;        // null: always focused
    std::function<void(trainer::LiveSeen)> followed;  // null: ignored

  private:
    Frame frame_;
};

}  // namespace stylet::test
