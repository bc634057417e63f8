// A trainee's attempts over time, and against others: CUSUM, learning curve, percentile. Pure functions over
// totals or outcomes, oldest first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace stylet::training {

// The CUSUM chart of failures. Based on Bolsin and Colson, "The use of the Cusum technique in the assessment
// of trainee competence in new procedures", Int. J. Qual. Health Care 12:433, 2000, after Wald's sequential
// probability ratio test. Hu et al., Am. J. Surg. 211:377, 2016 steered practice by it.
struct CusumSettings {
    double acceptable = 0.15;    // p0: share of failures of who is competent
    double unacceptable = 0.30;  // p1 > p0: of who is not
    double alpha = 0.1;          // chance to call a competent trainee incompetent
    double beta = 0.1;           // and the reverse
};

// What a chart is drawn with. A failure adds 1 - s, a success takes s away.
struct CusumLimits {
    double step = 0.0;     // s
    double lower_h = 0.0;  // so far below an earlier height: competent (p <= p0), with error beta
    double upper_h = 0.0;  // so far above one: not (p >= p1), with error alpha
};
// Settings out of 0 < p0 < p1 < 1, 0 < alpha, beta, alpha + beta < 1 assert.
CusumLimits cusumLimits(const CusumSettings&) noexcept;

enum class Verdict : std::uint8_t { open, competent, notYet };

// One point an attempt. A verdict is given where the line has moved by a limit from where the last verdict
// (or the chart) began; there the count begins anew.
struct CusumPoint {
    double height = 0.0;
    Verdict verdict = Verdict::open;  // given with this attempt
};
std::vector<CusumPoint> cusum(const std::vector<bool>& failed, const CusumSettings&);

// The least-squares fit of total = plateau - gain * exp(-(n - 1) / rate), n = 1, 2, ...: the exponential law
// of practice (Heathcote, Brown and Mewhort, Psychon. Bull. Rev. 7:185, 2000, who show that it fits single
// learners better than the power law). The rate is the best on a grid from half an attempt to ten times as
// many as there are; the other two are linear.
struct LearningCurve {
    double plateau = 0.0;                           // what the totals go toward
    double gain = 0.0;                              // so far below it was the first
    double rate = 1.0;                              // attempts in which what lacks falls to 1/e
    double rms = 0.0;                               // of what the curve leaves
    double at(std::size_t attempt) const noexcept;  // the first is 0
};
// Needs four attempts, and totals that differ.
std::optional<LearningCurve> learningCurve(std::span<const double> totals);

// The share of a cohort's totals below `total`, ties counting half: 0 to 1. None without a cohort.
std::optional<double> percentileIn(std::span<const double> cohort, double total) noexcept;

}  // namespace stylet::training
