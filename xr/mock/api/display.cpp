// XR_FB_display_refresh_rate.
#include <algorithm>

#include "api/api.h"
#include "world/director.h"
#include "world/objects.h"
#include "world/two_call.h"

namespace xrmock {

XrResult enumerateDisplayRefreshRates(Call& call, XrSession handle, std::uint32_t capacity,
                                      std::uint32_t* count, float* rates) {
    const Session& session = call.live<Session>(handle);
    return twoCall(capacity, count, rates, session.instance.scenario.refresh_rates_hz);
}

XrResult getDisplayRefreshRate(Call& call, XrSession handle, float* rate) {
    const Session& session = call.live<Session>(handle);
    requireValid(rate != nullptr, "displayRefreshRate is null");
    *rate = static_cast<float>(session.instance.scenario.refresh_hz);
    return XR_SUCCESS;
}

XrResult requestDisplayRefreshRate(Call& call, XrSession handle, float rate) {
    Session& session = call.live<Session>(handle);
    if (rate == 0) return XR_SUCCESS;  // no preference
    const auto& rates = session.instance.scenario.refresh_rates_hz;
    const auto offered = std::find_if(rates.begin(), rates.end(),
                                      [&](double each) { return static_cast<float>(each) == rate; });
    require(offered != rates.end(), XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB,
            "not one of the refresh rates that are offered");
    changeRefreshRate(session.instance, *offered);
    return XR_SUCCESS;
}

}  // namespace xrmock
