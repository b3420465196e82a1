//! Frames, messages, the state of the link, and the node.

use crate::arithmetic::now;
use crate::maps::grid;
use crate::robot::config;
use crate::{any, bytes, format_text, sink};
use amp::link::Link;
use amp::node::{FrameSink, Identity, NomadNode};
use amp::store::check;
use amp::wire::message::{Clock, FlashError, HostMessage, RobotCommand, TimedEcho};
use amp::wire::{CRC, Frame, Header, Receiver, Report, cobs, frame};
use heapless::Vec;

pub fn all() {
    coding();
    packing();
    receiving();
    linking();
    living();
}

fn header() -> Header {
    any(Header { session: 1, seq: 2 })
}

fn coding() {
    let mut room = any([0; 300]);
    sink(cobs::encode(any(&mut room[..])));
    sink(cobs::decode(bytes(), any(&mut room[..])));
    sink(CRC.checksum(bytes()));
}

/// Both directions of both kinds of messages.
fn packing() {
    if let Ok((header, message)) = frame::unpack::<HostMessage<16>>(bytes()) {
        packed(header, &message);
    }
    match frame::unpack::<Report<16>>(bytes()) {
        Ok((header, message)) => packed(header, &message),
        Err(why) => format_text(why),
    }
    let mut echoes = any(Vec::new());
    sink(echoes.push(any(TimedEcho {
        sensor: 1,
        range_mm: Some(2),
        age_ms: 3,
    })));
    packed(
        header(),
        &HostMessage::<16>::Scan {
            at_ms: any(1),
            echoes,
        },
    );
    let command = any(RobotCommand::<16>::Seek);
    packed(
        header(),
        &HostMessage::Command {
            at_ms: any(1),
            ttl_ms: any(2),
            command,
        },
    );
}

fn packed<M: serde::Serialize>(header: Header, message: &M) {
    match Frame::pack(header, message) {
        Ok(frame) => sink(any(frame).as_bytes()),
        Err(why) => format_text(why),
    }
}

fn receiving() {
    let mut receiver = any(Receiver::new());
    sink(receiver.push(any(1)));
    sink(receiver.oversized());
    sink(receiver);
}

fn linking() {
    let mut link = any(Link::new());
    link.open(header(), any(Clock::Host), now());
    sink(link.accept(header()));
    sink(link.heard(now(), now()));
    link.heard_timeless(now());
    sink((
        link.time(now()),
        link.age_ms(now(), now()),
        link.falls_silent(now()),
    ));
    sink(link);
}

/// A sink that may refuse any frame.
struct Anywhere;

impl FrameSink for Anywhere {
    fn send(&mut self, frame: &[u8]) -> bool {
        sink(frame);
        any(true)
    }
}

/// Flash with any content that may fail.
fn read(at: usize, out: &mut [u8]) -> bool {
    sink(at);
    for byte in out {
        *byte = any(1);
    }
    any(true)
}

fn living() {
    let mut node = any(NomadNode::new());
    node.start(
        &config(),
        grid(),
        any(Identity::default()),
        now(),
        &mut Anywhere,
    );
    node.frame(now(), bytes(), &mut Anywhere);
    sink(node.tick(now(), &mut Anywhere));
    node.ring_echo(any(3), any(None), any(1), now(), &mut Anywhere);
    sink(node.is_linked());
    let write = node.contents().write(any(1), &mut |bytes| {
        sink(bytes);
        any(Ok::<(), u8>(()))
    });
    sink(write.is_ok());
    sink(check(&mut read, any(8_256)).is_ok());
    sink(node.recall(&mut read, any(8_256)).is_ok());
    sink(node.flash_task());
    node.announce_pause(any(1), now(), &mut Anywhere);
    node.flash_done(any(Err(FlashError::Failed)), now(), &mut Anywhere);
    sink(node);
}
