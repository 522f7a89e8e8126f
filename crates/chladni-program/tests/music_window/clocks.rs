//! The beat from outside, and the beat for others.

use super::*;

/// An OSC message with one float, by the book: address and type tags padded to four bytes, big-endian number.
pub fn packet(address: &str, value: f32) -> Vec<u8> {
    let mut packet = address.as_bytes().to_vec();
    packet.resize(4 * (address.len() / 4 + 1), 0);
    packet.extend(b",f\0\0");
    packet.extend(value.to_be_bytes());
    packet
}

/// Sends until the window shows `what`: loopback may lose a packet.
pub fn send_until(window: &mut Window, port: u16, message: &[u8], what: &str) {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    wait(window, what, |window| {
        socket.send_to(message, (Ipv4Addr::LOCALHOST, port)).unwrap();
        shows(window, what)
    });
}

#[test]
fn the_beat_comes_from_outside_and_goes_out_again() {
    let folder = tempfile::tempdir().unwrap();
    let folders = folders(folder.path());
    let port = free_port();
    let ear = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    ear.set_read_timeout(Some(std::time::Duration::from_millis(20))).unwrap();
    let to = ear.local_addr().unwrap();
    let music = format!("osc_port = {port}\nfollows_clock = true\nbeat_out = \"{to}\"\n");
    let settings = folders.settings.clone().unwrap();
    std::fs::write(&settings, format!("harmonics = 24\n[music]\n{music}")).unwrap();
    let answers = Answers::default();
    let chooser = Box::new(answers.clone());
    let mut window = enter(Opening { folders, chooser, ..Opening::default() });
    click(&mut window, "drawer/remote");
    assert!(shows(&window, "No clock is heard yet"));
    send_until(&mut window, port, &packet("/tempo", 133.0), "133 BPM");
    window.run_steps(2);
    assert!(shows(&window, "The beat is that of the clock") && shows(&window, "100 % sure"));
    screenshot(&mut window, "window-music-clock.png");

    let wanted = ["/tempo 133", "/beat", "/bar", "/energy", "/section", "/bands"];
    let mut heard = Vec::new();
    let began = Instant::now();
    while began.elapsed() < chladni_testdata::HANGS {
        window.run_steps(1);
        let mut packet = [0u8; 512];
        while let Ok(length) = ear.recv(&mut packet) {
            let end = packet[..length].iter().position(|byte| *byte == 0).unwrap();
            let address = String::from_utf8(packet[..end].to_vec()).unwrap();
            if address == "/tempo" {
                let number: [u8; 4] = packet[length - 4..length].try_into().unwrap();
                heard.push(format!("/tempo {}", f32::from_be_bytes(number)));
            } else {
                heard.push(address);
            }
        }
        if wanted.iter().all(|all| heard.iter().any(|h| h == all)) {
            break;
        }
    }
    for address in wanted {
        assert!(heard.iter().any(|heard| heard == address), "{address}: {heard:?}");
    }

    window.key_press(Key::K);
    window.run_steps(2);
    assert!(shows(&window, "The tempo is held"));
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    for _ in 0..10 {
        socket.send_to(&packet("/tempo", 90.0), (Ipv4Addr::LOCALHOST, port)).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(20));
        window.run_steps(1);
    }
    assert!(shows(&window, "133 BPM"));
    window.key_press(Key::K);
    window.run_steps(2);
    send_until(&mut window, port, &packet("/tempo", 90.0), "90 BPM");
    // A tempo is kept once the beat is elsewhere than the one before it leads to.
    for _ in 0..10 {
        std::thread::sleep(std::time::Duration::from_millis(20));
        window.run_steps(1);
    }
    window.key_press(Key::OpenBracket);
    window.run_steps(2);
    assert!(shows(&window, "45 BPM"));
    // Back to the music.
    click(&mut window, "follow-clock");
    window.run_steps(2);
    assert!(shows(&window, "The beat is that of the music") && !shows(&window, "45 BPM"));
    // A film of the show has these beats, too.
    let show = saved_show(&mut window, &answers, &folder.path().join("clocked.toml"));
    let tempi: Vec<f64> = show.clock.marks().iter().filter_map(|mark| mark.bpm).map(f64::round).collect();
    assert_eq!(tempi.first(), Some(&133.0), "{tempi:?}");
    assert!(tempi.contains(&90.0) && tempi.contains(&45.0), "{tempi:?}");
    assert!(show.clock.marks().last().is_some_and(|mark| mark.bpm.is_none()));
}
