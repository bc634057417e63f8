// Variants of the reference patient: scans and diseases that the modeller has to handle or refuse. A variant
// is a row of a table (variants.cpp) with up to three small functions. Several variants can be combined.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patient/patient.h"
#include "patient/synth/trees.h"
#include "patient/synth/variants/scanner.h"

namespace stylet::patient::synth {

// What is decided before the first voxel is painted.
struct PatientPlan {
    Anatomy anatomy;
    Vec3 section{1.0};  // size of the image relative to the reference patient's
    Scanner scanner;
};

// What a painter of a disease works on, after the healthy organs are painted.
struct Painting {
    Canvas& canvas;
    const Anatomy& anatomy;
    const HepaticTrees& trees;
    std::vector<Inclusion>& inclusions;
};

struct Variant {
    std::string_view name, changes, source;
    void (*plan)(PatientPlan&) = nullptr;  // anatomy, image size, scanner
    void (*paint)(Painting&) = nullptr;    // labels and inclusions
    void (*finish)(Package&) = nullptr;    // the finished package: slices, field of view, header
};

std::span<const Variant> variantTable();

// What the variants change in a plan.
struct PlanField {
    std::string_view name;  // "noise"
    Vec3 (*value)(const PatientPlan&);
};
std::span<const PlanField> planFields();

// Variants with these names, in the order of the table. Throws std::invalid_argument for an unknown name, and
// for two variants that set the same field of the plan to different values. Factors and shifts of the same
// field combine.
std::vector<const Variant*> findVariants(const std::vector<std::string>& names);

}  // namespace stylet::patient::synth
