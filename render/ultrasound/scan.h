// Settings, input and statistics of a scan, and the plan that follows from them: steps, bins, planes, pulse
// and beam.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "render/ultrasound/needle_echo.h"
#include "render/ultrasound/scan_shared.h"

namespace stylet::patient {
struct VesselFlow;
}

namespace stylet::render {

// Colour Doppler inside a box of the picture.
struct DopplerBox {
    double from_share = 0.35, to_share = 0.65;  // range of the lines, 0 to 1
    double from_m = 0.04, to_m = 0.11;          // range of drawn depth
    double nyquist_m_per_s = 0.30;              // pulse rate * wavelength / 4; faster blood is aliased
    double wall_filter_m_per_s = 0.02;
    double gain_db = 0.0;
    friend bool operator==(const DopplerBox&, const DopplerBox&) = default;
};

inline constexpr int kTgcSliders = 8;

// How lines are computed. Automatic: serially if Vulkan runs in software, by prefix sums on a GPU.
enum class ScanPath : std::uint8_t { automatic, prefix_sums, serial };

struct UltrasoundSettings {
    double depth_m = 0.0, frequency_hz = 0.0, focus_m = 0.0;  // 0: the transducer's default
    double gain_db = 0.0;
    std::array<double, kTgcSliders> tgc_db{};  // one per depth range, from the face to the full depth
    double compensation_db_per_cm_mhz = 0.55;  // one way; the attenuation that the machine assumes
    double dynamic_range_db = 60.0;
    bool freeze = false;  // no new scan: shows the last one with the current gains and marks
    std::optional<DopplerBox> doppler;
    // Resolution of the scan (bench imaging.ultrasound).
    int lines = 256, samples = 512, planes = 3;
    double reach_sigma = 1.5;  // standard deviations over which the beam's width is summed
    int place_samples = 4;     // samples (and half as many lines) that share a look-up of breath and tool
    double noise_db = -125.0;  // electronic noise relative to a perfect mirror; below -300: none
    double gel_m = 0.004;      // gaps up to this thickness are filled with gel
    ScanPath path = ScanPath::automatic;
    int width = 512, height = 416;  // size of the picture, pixels
    struct Skips {
        bool lines_in_air = true;  // lines that do not touch are not marched
        friend bool operator==(const Skips&, const Skips&) = default;
    } skips;
    friend bool operator==(const UltrasoundSettings&, const UltrasoundSettings&) = default;
};

struct UltrasoundInput {
    std::optional<Pose> patient_from_probe;   // deformed patient
    std::optional<Pose> patient_from_needle;  // deformed patient
    NeedleShape needle;
    std::vector<CurvedTube> tubes;  // deformed patient: guide wire, dilator and drain
    // Injected fluid around its centre, reference frame; the radius of a ball of the same volume. Only the
    // first gpu::kMaxDepots are shown.
    struct Depot {
        Vec3 centre_reference_m{0.0};
        double radius_m = 0.0;
    };
    std::vector<Depot> depots;
    std::optional<std::array<Vec3, 2>>
        guide_m;               // deformed patient: drawn dashed where it lies in the picture
    double time_s = 0.0;       // determines the heartbeat's phase
    std::uint64_t number = 0;  // number of the picture: seed of its electronic noise
};

// Statistics of the last picture.
struct UltrasoundStats {
    std::string_view reason;           // why the picture is black; empty if it is not
    double contact = 0.0;              // share of the face that touches
    std::uint64_t samples = 0;         // marched
    std::uint64_t look_ups = 0;        // of breath and tool
    std::uint64_t still_pictures = 0;  // 1: without deformation
    std::uint64_t skipped_lines = 0;
    std::uint64_t frozen_pictures = 0;  // 1: nothing was scanned
};

// Parameters of a scan that follow from transducer and settings.
struct ScanPlan {
    double depth_m = 0.0, frequency_hz = 0.0, focus_m = 0.0;
    double step_m = 0.0;  // between samples along a line
    double bin_m = 0.0;   // size of a bin of drawn depth
    double amplified_np_per_m = 0.0;
    struct Plane {
        double sigmas = 0.0, weight = 0.0;
    };
    std::vector<Plane> planes;
    std::array<double, 7> pulse{};  // taps in bins, from the middle; their sum over both sides is 1
    int taps() const;               // index of the last tap that counts, on either side
    double mirror_scale = 1.0;      // so that the echo of a perfect mirror is 1
    struct Depth {
        double thickness_sigma_m = 0.0, width_sigma_lines = 0.0;
        double speckle = 1.0;  // scales unit noise so that it has unit strength after pulse and beam
        double gain = 1.0;     // factor of the drawn amplitude; 1 is white
    };
    std::vector<Depth> depths;  // per sample and per bin
};
ScanPlan makeScanPlan(const Transducer&, const UltrasoundSettings&);
// Updates the gains of the plan from other settings.
void setGains(ScanPlan&, const UltrasoundSettings&);

// Correlation of the scatterers' noise at two points.
double scattererCorrelation(double apart_m);

// Returns the reason why nothing can be scanned; empty if a scan is possible.
std::string_view noScanReason(const UltrasoundInput&, const UltrasoundSettings&, const Transducer&);

inline constexpr double kNeperPerDb = 0.11512925464970229;
inline constexpr int kMaxLines = 1024, kMaxSamples = 2048, kMaxScannedPlanes = gpu::kMaxPlanes;
inline constexpr double kScatterers_m = 0.0005;  // spacing of the nodes of the scatterers' lattice
inline constexpr double kWhite_db = -16.0;       // echo that is drawn white at gain 0
// A line is marched this much further than drawn, because sound is faster in muscle than the machine
// assumes.
inline constexpr double kMarchedShare = 1.03;

}  // namespace stylet::render
