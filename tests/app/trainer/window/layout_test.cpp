#include "app/trainer/window/layout.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace stylet::trainer {
namespace {

bool overlap(const Rect& a, const Rect& b) {
    return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

bool within(const Rect& inner, int width, int height) {
    return inner.x >= 0 && inner.y >= 0 && inner.x + inner.width <= width &&
           inner.y + inner.height <= height && inner.width > 0 && inner.height > 0;
}

TEST(Layout, APictureFitsInTheMiddleAndIsNeverStretched) {
    EXPECT_EQ(fitted({10, 20, 400, 200}, 100, 100), (Rect{110, 20, 200, 200}));
    EXPECT_EQ(fitted({0, 0, 300, 600}, 200, 100), (Rect{0, 225, 300, 150}));
    EXPECT_EQ(fitted({0, 0, 50, 50}, 1000, 100), (Rect{0, 22, 50, 5}));
    EXPECT_EQ(fitted({5, 5, 50, 50}, 0, 0).width, 0);
}

TEST(Layout, OneViewHasTheWindowToItself) {
    for (int view = 0; view < int(WindowView::overview); ++view) {
        const Layout layout = computeLayout(WindowView(view), WindowView::leftEye, 1280, 720);
        ASSERT_EQ(layout.panes.size(), 1u);
        EXPECT_EQ(layout.panes[0].shows, WindowView(view));
        EXPECT_EQ(layout.panes[0].area, (Rect{8, 34, 1264, 648}));
        EXPECT_EQ(layout.keys, (Rect{0, 690, 1280, 30}));
    }
}

TEST(Layout, TheOverviewShowsFourThingsSideBySideInEveryWindow) {
    for (const auto& [width, height] :
         {std::pair{1280, 720}, {3840, 2160}, {640, 480}, {600, 1000}, {320, 200}}) {
        const Layout layout = computeLayout(WindowView::overview, WindowView::camera, width, height);
        ASSERT_EQ(layout.panes.size(), 4u);
        EXPECT_EQ(layout.panes[0].shows, WindowView::camera);
        std::vector<Rect> all;
        for (const Pane& pane : layout.panes) {
            all.push_back(pane.caption), all.push_back(pane.area);
            EXPECT_TRUE(within(pane.area, width, height)) << width << " x " << height;
            EXPECT_GE(layout.panes[0].area.width * layout.panes[0].area.height,
                      pane.area.width * pane.area.height);
        }
        all.push_back(layout.keys);
        for (std::size_t i = 0; i < all.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                EXPECT_FALSE(overlap(all[i], all[j])) << width << " x " << height << ": " << i << ", " << j;
    }
}

TEST(Layout, SlicesStandBelowTheLargePictureAndKeysHaveTheRowsTheyNeed) {
    const LayoutSettings settings{.key_rows = 3, .slices = true};
    const Layout layout = computeLayout(WindowView::overview, WindowView::leftEye, 1440, 900, settings);
    ASSERT_EQ(layout.panes.size(), 5u);
    EXPECT_EQ(layout.panes.back().shows, WindowView::slices);
    EXPECT_EQ(layout.keys.height, kKeys + 2 * kKeyRowHeight);
    std::vector<Rect> all{layout.keys};
    for (const Pane& pane : layout.panes) {
        EXPECT_TRUE(within(pane.area, 1440, 900)) << nameOf(pane.shows);
        all.push_back(pane.caption), all.push_back(pane.area);
    }
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_FALSE(overlap(all[i], all[j])) << i << ", " << j;
    EXPECT_GT(layout.panes.front().area.height, layout.panes.back().area.height);
}

TEST(Layout, KeysTakeAThirdOfTheWindowAtMost) {
    const Layout layout = computeLayout(WindowView::leftEye, WindowView::leftEye, 720, 440, {.key_rows = 12});
    EXPECT_EQ(layout.keys.height, kKeys + 5 * kKeyRowHeight);
    EXPECT_GT(layout.panes[0].area.height, 220);
    EXPECT_EQ(maxKeyRows(440), 6);
    EXPECT_EQ(maxKeyRows(300), 0) << "too small for any";
}

TEST(Layout, TheGuideStandsWhereTheMetricsWouldBe) {
    for (const auto& [width, height] : {std::pair{1440, 900}, {1100, 700}, {600, 1000}}) {
        const Layout layout = computeLayout(WindowView::overview, WindowView::leftEye, width, height,
                                            {.slices = true, .guide = true});
        std::vector<Rect> all{layout.keys};
        int guides = 0;
        for (const Pane& pane : layout.panes) {
            EXPECT_NE(pane.shows, WindowView::metrics);
            guides += pane.shows == WindowView::guide;
            EXPECT_TRUE(within(pane.area, width, height)) << nameOf(pane.shows);
            all.push_back(pane.caption), all.push_back(pane.area);
        }
        EXPECT_EQ(guides, 1);
        for (std::size_t i = 0; i < all.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                EXPECT_FALSE(overlap(all[i], all[j])) << width << " x " << height << ": " << i << ", " << j;
    }
}

TEST(Layout, SmallWindowShowsOnlyTheEye) {
    for (const auto& [width, height] : {std::pair{200, 400}, {400, 100}, {1, 1}}) {
        const Layout layout = computeLayout(WindowView::overview, WindowView::rightEye, width, height);
        ASSERT_EQ(layout.panes.size(), 1u);
        EXPECT_EQ(layout.panes[0].shows, WindowView::rightEye);
        EXPECT_GT(layout.panes[0].area.width, 0);
        EXPECT_GT(layout.panes[0].area.height, 0);
    }
}

}  // namespace
}  // namespace stylet::trainer
