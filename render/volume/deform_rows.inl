// Included by deform_rows.cpp once for each instruction set, in a namespace that defines ROW_FN, ROW_TARGET
// and fetchNode.

struct Flow {
    Float4 last, metres;
    Int4 last_low;
    std::size_t row, plane;
    float per_step_m;
};

// xyz: the field at a point. Outside the grid the border's value.
ROW_FN Float4 fieldAt(const Flow& f, const float* nodes, Float4 at) {
    at = at > 0.0f ? at : Float4{};
    at = at < f.last ? at : f.last;
    Int4 low = __builtin_convertvector(at, Int4);
    low = low < f.last_low ? low : f.last_low;
    const float* node = nodes + 4 * (std::size_t(std::uint32_t(low[2])) * f.plane +
                                     std::size_t(std::uint32_t(low[1])) * f.row + std::size_t(std::uint32_t(low[0])));
    return fetchNode(node, 4 * f.row, 4 * f.plane, at - __builtin_convertvector(low, Float4));
}

// Follows the flow from `at`: a short path in one midpoint step, a long one in Runge-Kutta steps. `field`:
// fieldAt(at).
ROW_FN Float4 back(const Flow& f, const float* nodes, Float4 at, Float4 field) {
    const Float4 way = field * f.metres;
    const float length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    if (length == 0.0f) return at;
    const float needed = length * f.per_step_m;
    if (needed < 1.0f) return at + fieldAt(f, nodes, at + 0.5f * field);
    const int steps = 1 + int(needed * 0.125f);
    const float share = 1.0f / float(steps);
    for (int i = 0;;) {
        const Float4 second = fieldAt(f, nodes, at + 0.5f * share * field);
        const Float4 third = fieldAt(f, nodes, at + 0.5f * share * second);
        const Float4 fourth = fieldAt(f, nodes, at + share * third);
        at += share * (1.0f / 6.0f) * (field + 2.0f * (second + third) + fourth);
        if (++i == steps) return at;
        field = fieldAt(f, nodes, at);
    }
}

ROW_FN Flow makeFlow(const FlowNodes& n) {
    const glm::ivec3 last = n.dims - 1;
    // The fourth lane is unused.
    return {Float4{float(last.x), float(last.y), float(last.z), 0.0f},
            Float4{n.metres.x, n.metres.y, n.metres.z, 0.0f},
            Int4{last.x - 1, last.y - 1, last.z - 1, 0},
            std::size_t(n.dims.x),
            std::size_t(n.dims.x) * std::size_t(n.dims.y),
            1.0f / n.step_m};
}

ROW_TARGET void wallRow(const FlowNodes& n, const glm::vec3& first, int count, float* wall_displacement) {
    const Flow f = makeFlow(n);
    for (int i = 0; i < count; ++i) {
        const Float4 p{first.x + float(i), first.y, first.z, 0.0f};
        const Float4 moved = back(f, n.wall, p, fieldAt(f, n.wall, p)) - p;
        std::memcpy(wall_displacement + 4 * i, &moved, sizeof moved);
    }
}

ROW_TARGET void tableRow(const FlowNodes& n, const glm::vec3& first, float step, int count, bool far,
                         glm::vec4* inside, glm::vec4* outside) {
    const Flow f = makeFlow(n);
    for (int i = 0; i < count; ++i) {
        const Float4 p{first.x + float(i) * step, first.y, first.z, 0.0f};
        const Float4 moved = fieldAt(f, n.wall_displacement, p);
        const Float4 out = moved * f.metres;
        std::memcpy(&outside[i].x, &out, sizeof out);
        if (far) continue;
        Float4 before = p + moved;
        before[3] = 0.0f;
        const Float4 there = fieldAt(f, n.slide, before);
        Float4 in = there[3] > n.far_m ? before : back(f, n.slide, before, there);
        in = (in - p) * f.metres;
        in[3] = there[3];
        std::memcpy(&inside[i].x, &in, sizeof in);
    }
}
