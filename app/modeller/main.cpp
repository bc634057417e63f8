// stylet-model: makes, checks and shows virtual patients.
#include <iostream>

#include "app/modeller/commands.h"

int main(int argc, char** argv) {
    CLI::App app{"stylet-model: makes, checks and shows virtual patients"};
    app.require_subcommand(1);
    stylet::app::addSynth(app);
    stylet::app::addCheck(app);
    stylet::app::addSlices(app);
    try {
        CLI11_PARSE(app, argc, argv);
    } catch (const std::exception& e) {
        std::cerr << "stylet-model: " << e.what() << '\n';
        return 2;
    }
    return 0;
}
