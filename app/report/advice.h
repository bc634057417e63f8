// Advice from an attempt's largest losses, each with the moment in the record at which it happened.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "app/report/attempt_figures.h"
#include "app/training/losses.h"

namespace stylet::report {

// The score of a result. Empty if it was made with another version of the metric table: then the reason for a
// loss is unknown.
std::optional<training::Score> findScore(const records::AttemptResult&);

struct Advice {
    std::string text;     // sentences: what to do, and what was lost
    double t_s = 0.0;     // in the record
    std::size_t row = 0;  // index into `course` of the tick at that time; 0 if there are none
};
inline constexpr std::size_t kMaxAdvice = 3;

// Largest loss first. Empty for an attempt without a score or without a loss, and for one that reached
// nothing.
std::vector<Advice> makeAdvice(const LoadedAttempt&);

// What the record contains at those moments. Row i has the id "moment-<i + 1>".
Table momentTable(const LoadedAttempt&, const std::vector<Advice>&);
// Marks the moments on a timeline. `first`: number of the first advice.
void markMoments(Figure& timeline, const std::vector<Advice>&, std::size_t first = 1);
// The moment on the force curve, or on the timeline around it if the needle is not in the body. `number`: of
// the advice, from 1. None if that part of the timeline contains nothing but tools.
std::optional<DescribedFigure> momentFigure(const LoadedAttempt&, const Advice&, std::size_t number);

}  // namespace stylet::report
