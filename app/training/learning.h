// Statistics of a trainee's attempts over time and compared with others: CUSUM, learning curve, percentile.
// Pure functions of totals or outcomes, oldest first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace stylet::training {

// CUSUM chart of failures. Based on Bolsin and Colson, "The use of the Cusum technique in the assessment of
// trainee competence in new procedures", Int. J. Qual. Health Care 12:433, 2000, after Wald's sequential
// probability ratio test. Hu et al., Am. J. Surg. 211:377, 2016 used it to steer practice.
struct CusumSettings {
    double acceptable = 0.15;    // p0: failure rate of a competent trainee
    double unacceptable = 0.30;  // p1 > p0: failure rate of an incompetent trainee
    double alpha = 0.1;          // probability of rating a competent trainee incompetent
    double beta = 0.1;           // probability of rating an incompetent trainee competent
};

// Limits of a chart. A failure adds 1 - s to the height, a success subtracts s.
struct CusumLimits {
    double step = 0.0;     // s
    double lower_h = 0.0;  // a fall by this much: competent (p <= p0), with error beta
    double upper_h = 0.0;  // a rise by this much: not competent (p >= p1), with error alpha
};
// Asserts 0 < p0 < p1 < 1, 0 < alpha, 0 < beta, alpha + beta < 1.
CusumLimits cusumLimits(const CusumSettings&) noexcept;

enum class Verdict : std::uint8_t { open, competent, notYet };

// One point per attempt. An attempt gets a verdict if the height has moved by a limit since the last verdict
// (or since the start of the chart). After a verdict, the distance is measured from the height at that
// attempt.
struct CusumPoint {
    double height = 0.0;
    Verdict verdict = Verdict::open;  // of this attempt
};
std::vector<CusumPoint> cusum(const std::vector<bool>& failed, const CusumSettings&);

// Least-squares fit of total = plateau - gain * exp(-(n - 1) / rate), n = 1, 2, ...: the exponential law of
// practice (Heathcote, Brown and Mewhort, Psychon. Bull. Rev. 7:185, 2000, who show that it fits individual
// learners better than the power law). The rate is searched on a grid from half an attempt to ten times the
// number of attempts. Plateau and gain are linear.
struct LearningCurve {
    double plateau = 0.0;  // limit of the totals
    double gain = 0.0;     // plateau minus the fitted first total
    double rate = 1.0;     // attempts in which the gap to the plateau falls to 1/e
    double rms = 0.0;      // of the residuals
    // The totals support the curve: its Akaike criterion, corrected for small samples (Hurvich and Tsai,
    // Biometrika 76:297, 1989), is below that of a constant total. False for fewer than six totals.
    bool supported = false;
    double at(std::size_t attempt) const noexcept;  // the first attempt is 0
};
// Returns nothing for fewer than four totals, for equal totals, or if a total is not finite.
std::optional<LearningCurve> learningCurve(std::span<const double> totals);

// Share of the cohort's totals below `total`, 0 to 1; ties count half. NaN totals in the cohort are
// ignored. Returns nothing without a cohort or if `total` is NaN.
std::optional<double> percentileRank(std::span<const double> cohort, double total) noexcept;

}  // namespace stylet::training
