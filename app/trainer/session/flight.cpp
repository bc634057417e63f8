#include "app/trainer/session/flight.h"

#include <sstream>

#include "base/whole_file.h"
#include "patient/package/package.h"

namespace stylet::trainer {

namespace {

using haptics::TickRecord;

std::uint64_t faultTick(const std::vector<TickRecord>& flight) {
    std::uint32_t before = flight.front().output.faults;
    for (const TickRecord& record : flight) {
        if ((record.output.faults & ~before) != 0) return record.output.tick;
        before = record.output.faults;
    }
    return flight.front().output.tick;
}

void writeVector(std::ostream& stream, const Vec3& v) {
    stream << ',' << v.x << ',' << v.y << ',' << v.z;
}

}  // namespace

void writeFlight(const std::vector<TickRecord>& flight, double dt_s, const std::filesystem::path& csv) {
    if (flight.empty()) return;
    const std::uint64_t zero = faultTick(flight);
    std::ostringstream stream;
    stream.precision(9);
    stream << "t_s,tick,stage,level,faults,awaited,flags,fresh,buttons,commands,"
              "tip_device_x_m,tip_device_y_m,tip_device_z_m,"
              "model_x_n,model_y_n,model_z_n,sent_device_x_n,sent_device_y_n,sent_device_z_n,"
              "controller_device_x_n,controller_device_y_n,controller_device_z_n,depth_m\n";
    for (const TickRecord& record : flight) {
        const haptics::TickOutput& out = record.output;
        const haptics::DeviceState& device = record.input.device;
        stream << double(std::int64_t(out.tick - zero)) * dt_s << ',' << out.tick << ','
               << enumName(kForceStageNames, out.stage) << ',' << out.level << ',' << faultNames(out.faults)
               << ',' << faultNames(out.awaited) << ',' << device.flags << ',' << device.fresh << ','
               << device.buttons << ',' << record.input.command_count;
        writeVector(stream, device.device_from_stylus.position_m);
        writeVector(stream, out.tool_force.force_n);
        writeVector(stream, out.sent_device_n);
        writeVector(stream, out.controller_device_n);
        stream << ',' << out.depth_m << '\n';
    }
    writeWholeFile(csv, stream.view());
}

}  // namespace stylet::trainer
