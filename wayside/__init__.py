"""What the ground decides: block manager (閉そく管理装置), point terminals (制御端末装置), their hosts."""
