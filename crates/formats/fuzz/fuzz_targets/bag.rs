//! Bags of ROS 1: reads contents, and the messages of all channels.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sigmatau_formats::ros::LogKind;

mod ros_log;

fuzz_target!(|data: &[u8]| ros_log::read(data, LogKind::Bag));
