//! Tables of a remote controller's properties, counters and parameters.

use super::FollowError;
use crate::cli::table::plain;
use amp::parameters::{Parameter, ParameterError, ParameterSpec};
use files::error::BadInput;
use remote::link::{Session, build, oscillator, reset};
use std::io::Write;

/// The requested parameters; with a single one optionally its new value.
pub(super) struct RequestedParameters {
    parameters: Vec<Parameter>,
    value: Option<i32>,
}

/// Finds the parameters by name; all of them without a name.
///
/// # Errors
/// An unknown name, a value outside its range.
pub(super) fn wanted(
    name: Option<&str>,
    value: Option<i32>,
) -> Result<RequestedParameters, BadInput> {
    let Some(name) = name else {
        let parameters = Parameter::ALL.to_vec();
        return Ok(RequestedParameters { parameters, value });
    };
    // A former spelling.
    let name = if name == "believed" { "enabled" } else { name };
    let known: Vec<_> = Parameter::ALL.iter().map(|known| known.name()).collect();
    let found = Parameter::ALL
        .into_iter()
        .find(|known| known.name() == name);
    let parameter = found.ok_or_else(|| BadInput::unknown("parameter", name, &known))?;
    let spec = parameter.spec();
    match value {
        Some(value) if value < spec.min || value > spec.max => {
            let why = ParameterError::OutOfRange(spec).to_string();
            let why = why.trim_end();
            Err(BadInput::new(format!(
                "parameter {name} cannot be {value}: {why}"
            )))
        }
        _ => Ok(RequestedParameters {
            parameters: vec![parameter],
            value,
        }),
    }
}

/// Reads or sets the parameters and prints them.
pub(super) fn parameters(
    session: &mut Session,
    wanted: RequestedParameters,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    let mut rows = Vec::new();
    for parameter in wanted.parameters {
        let (value, spec) = session.parameter(parameter, wanted.value)?;
        rows.push(row(parameter, value, &spec));
    }
    let heads = ["parameter", "value", "least", "greatest", "unit"];
    Ok(out.write_all(plain(&heads, &rows, &[1, 2, 3]).as_bytes())?)
}

fn row(parameter: Parameter, value: i32, spec: &ParameterSpec) -> Vec<String> {
    vec![
        parameter.name().to_owned(),
        value.to_string(),
        spec.min.to_string(),
        spec.max.to_string(),
        spec.unit.to_string(),
    ]
}

/// Reads the counters and prints them.
pub(super) fn counters(session: &mut Session, out: &mut impl Write) -> Result<(), FollowError> {
    let c = session.counters()?;
    let rows = [
        ("frames accepted", c.accepted),
        ("malformed frames", c.malformed),
        ("frames with a wrong CRC", c.crc_errors),
        ("frames without a known message", c.unknown),
        ("frames too long", c.oversized),
        ("frames of another session", c.wrong_session),
        ("duplicate or late frames", c.replayed),
        ("commands that came too late", c.expired),
        ("requests refused", c.refused),
        ("frames sent", c.sent),
        ("frames lost by a full send queue", c.dropped),
        ("times the link was lost", c.link_losses),
        ("echoes too old to be used", c.stale_echoes),
        ("bytes lost by the serial port", c.device.overruns),
        ("bytes lost by the receive queue", c.device.queue_losses),
        ("peak stack use, bytes", c.device.stack_peak_bytes),
        ("control ticks", c.device.ticks),
        ("longest time between two, ms", c.device.longest_tick_ms),
        ("invalid firings of its ring", c.device.ring_faults),
    ];
    let rows = rows.map(|(what, count)| vec![what.to_owned(), count.to_string()]);
    let drift = vec![
        "ms that this clock fell behind".to_owned(),
        c.clock_drift_ms.to_string(),
    ];
    let rows = [&rows[..], &[drift]].concat();
    Ok(out.write_all(plain(&["counter", "since the start"], &rows, &[1]).as_bytes())?)
}

/// Prints the controller's hello message.
pub(super) fn hello(session: &Session, out: &mut impl Write) -> Result<(), FollowError> {
    let Some(hello) = session.hello() else {
        return Ok(());
    };
    let dimensions = &hello.dimensions;
    let rows = [
        ("build", build(&hello.build)),
        ("started because", reset(hello.reset).to_owned()),
        ("clocked by", oscillator(hello.oscillator).to_owned()),
        ("protocol", dimensions.protocol.to_string()),
        ("messages", format!("{:08x}", dimensions.schema)),
        ("sonars", dimensions.sensors.to_string()),
        ("neurons to a map", dimensions.neurons.to_string()),
        ("samples the memory holds", hello.samples.to_string()),
        (
            "checksum of the configuration",
            format!("{:08x}", hello.config_crc),
        ),
        ("checksum of the maps", format!("{:08x}", hello.maps_crc)),
        (
            "checksum of the memory",
            format!("{:08x}", hello.memory_crc),
        ),
    ];
    let rows = rows.map(|(what, value)| vec![what.to_owned(), value]);
    Ok(out.write_all(plain(&["controller", ""], &rows, &[]).as_bytes())?)
}
